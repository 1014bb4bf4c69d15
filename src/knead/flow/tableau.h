// Explicit Runge-Kutta methods with an error estimate, as data.
#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace knead {

// The Runge-Kutta methods.
enum class Integrator {
  rk4,               // the paper's: classical RK4 with step doubling, local extrapolation off
  bogacki_shampine,  // 3(2), Bogacki and Shampine 1989
  dormand_prince,    // 5(4), Dormand and Prince 1980
  tsitouras          // 5(4), Tsitouras 2011
};

// Returns the method with this name: rk4, bs32, dp54 or tsit5, or runge-kutta, bogacki-shampine, dormand-prince or
// tsitouras. Nothing for another name.
std::optional<Integrator> integrator_named(std::string_view name);

// The coefficients of a method: k_i = f(t + c_i h, x + h sum_j a_ij k_j); the step is h sum_i b_i k_i and the estimate
// of its error h sum_i e_i k_i.
struct Tableau {
  static constexpr int kMaxStages = 11;

  int stages = 0;
  int order = 0;        // of the solution with which the integration continues
  int error_order = 0;  // the estimate is O(h^(error_order + 1))
  bool first_same_as_last = false;
  std::array<double, kMaxStages> c{};
  std::array<std::array<double, kMaxStages>, kMaxStages> a{};
  std::array<double, kMaxStages> b{};
  std::array<double, kMaxStages> e{};
};

// Returns the coefficients of a method.
const Tableau& tableau(Integrator integrator);

}  // namespace knead
