#include "knead/flow/tableau.h"

#include <initializer_list>
#include <vector>

namespace knead {

namespace {

using Row = std::vector<double>;

Tableau make_tableau(int order, int error_order, bool fsal, const std::vector<Row>& a, const Row& b, const Row& lower) {
  Tableau t;
  t.stages = static_cast<int>(b.size());
  t.order = order;
  t.error_order = error_order;
  t.first_same_as_last = fsal;
  for (std::size_t i = 0; i < a.size(); ++i) {
    double sum = 0;
    for (std::size_t j = 0; j < a[i].size(); ++j) {
      t.a[i + 1][j] = a[i][j];
      sum += a[i][j];
    }
    t.c[i + 1] = sum;
  }
  for (std::size_t i = 0; i < b.size(); ++i) {
    t.b[i] = b[i];
    t.e[i] = b[i] - lower[i];
  }
  return t;
}

// Two half steps of classical RK4 (stages 0 to 3 and 4 to 7) against one whole step (stages 0, 8, 9, 10); the
// difference divided by 2^4 - 1 estimates the error of the half steps.
Tableau make_rk4() {
  const double s = 1.0 / 6.0;
  const std::vector<Row> a = {{0.25},
                              {0, 0.25},
                              {0, 0, 0.5},
                              {s / 2, s, s, s / 2},
                              {s / 2, s, s, s / 2, 0.25},
                              {s / 2, s, s, s / 2, 0, 0.25},
                              {s / 2, s, s, s / 2, 0, 0, 0.5},
                              {0.5},
                              {0, 0, 0, 0, 0, 0, 0, 0, 0.5},
                              {0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};
  const Row halves = {s / 2, s, s, s / 2, s / 2, s, s, s / 2, 0, 0, 0};
  const Row whole = {s, 0, 0, 0, 0, 0, 0, 0, 2 * s, 2 * s, s};
  Tableau t = make_tableau(4, 4, false, a, halves, whole);
  for (double& e : t.e) e /= 15.0;
  return t;
}

Tableau make_bogacki_shampine() {
  return make_tableau(3, 2, true, {{1.0 / 2}, {0, 3.0 / 4}, {2.0 / 9, 1.0 / 3, 4.0 / 9}},
                      {2.0 / 9, 1.0 / 3, 4.0 / 9, 0}, {7.0 / 24, 1.0 / 4, 1.0 / 3, 1.0 / 8});
}

Tableau make_dormand_prince() {
  const Row b = {35.0 / 384, 0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84};
  const std::vector<Row> a = {{1.0 / 5},
                              {3.0 / 40, 9.0 / 40},
                              {44.0 / 45, -56.0 / 15, 32.0 / 9},
                              {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
                              {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
                              b};
  return make_tableau(5, 4, true, a, {b[0], b[1], b[2], b[3], b[4], b[5], 0},
                      {5179.0 / 57600, 0, 7571.0 / 16695, 393.0 / 640, -92097.0 / 339200, 187.0 / 2100, 1.0 / 40});
}

// C. Tsitouras, Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption, 2011, Table 1.
Tableau make_tsitouras() {
  const Row b = {0.09646076681806523, 0.01, 0.4798896504144996, 1.379008574103742, -3.290069515436081,
                 2.324710524099774};
  const std::vector<Row> a = {
      {0.161},
      {-0.008480655492356989, 0.335480655492357},
      {2.8971530571054935, -6.359448489975075, 4.3622954328695815},
      {5.325864828439257, -11.748883564062828, 7.4955393428898365, -0.09249506636175525},
      {5.86145544294642, -12.92096931784711, 8.159367898576159, -0.071584973281401, -0.028269050394068383},
      b};
  const Row error = {-0.00178001105222577714, -0.0008164344596567469, 0.007880878010261995, -0.1447110071732629,
                     0.5823571654525552,      -0.45808210592918697,   0.015151515151515152};
  Row lower = {b[0], b[1], b[2], b[3], b[4], b[5], 0};
  for (std::size_t i = 0; i < lower.size(); ++i) lower[i] -= error[i];
  return make_tableau(5, 4, true, a, {b[0], b[1], b[2], b[3], b[4], b[5], 0}, lower);
}

}  // namespace

const Tableau& tableau(Integrator integrator) {
  static const Tableau rk4 = make_rk4();
  static const Tableau bogacki_shampine = make_bogacki_shampine();
  static const Tableau dormand_prince = make_dormand_prince();
  static const Tableau tsitouras = make_tsitouras();
  switch (integrator) {
    case Integrator::rk4:
      return rk4;
    case Integrator::bogacki_shampine:
      return bogacki_shampine;
    case Integrator::dormand_prince:
      return dormand_prince;
    case Integrator::tsitouras:
      return tsitouras;
  }
  return dormand_prince;
}

std::optional<Integrator> integrator_named(std::string_view name) {
  struct Entry {
    std::string_view name;
    std::string_view long_name;
    Integrator integrator;
  };
  constexpr std::array<Entry, 4> entries{{{"rk4", "runge-kutta", Integrator::rk4},
                                          {"bs32", "bogacki-shampine", Integrator::bogacki_shampine},
                                          {"dp54", "dormand-prince", Integrator::dormand_prince},
                                          {"tsit5", "tsitouras", Integrator::tsitouras}}};
  for (const Entry& entry : entries) {
    if (name == entry.name || name == entry.long_name) return entry.integrator;
  }
  return std::nullopt;
}

}  // namespace knead
