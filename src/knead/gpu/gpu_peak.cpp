// The arithmetic that a GPU can do at most.
#include <algorithm>
#include <chrono>
#include <limits>

#include "knead/gpu/gpu.h"
#include "knead/gpu/gpu_state.h"

namespace knead::gpu {

namespace {

constexpr std::size_t kThreadsToAWorkGroup = 64;  // as in the shader
constexpr std::size_t kWorkGroups = 1024;
constexpr std::size_t kMultiplyAddsToARound = 64;
constexpr int kMostRounds = 60'000;   // Mesa stops loops on the CPU after 65535
constexpr double kLongEnough = 0.02;  // seconds
constexpr double kMostOfACall = 0.8;  // to be had by the rounds: what a call takes in itself varies
constexpr int kRepetitions = 4;

// Sixteen chains of multiply-adds that do not wait for one another, and end in a sum that the compiler cannot know.
constexpr const char* kShader = R"(#version 430 core
layout(local_size_x = 64) in;
layout(std430, binding = 0) restrict writeonly buffer Result { float result[]; };
uniform int rounds;
uniform float factor;
uniform float summand;

void main() {
  vec4 a = vec4(gl_LocalInvocationID.x) * vec4(1.0, 2.0, 3.0, 4.0);
  vec4 b = a + 5.0;
  vec4 c = a + 6.0;
  vec4 d = a + 7.0;
  vec4 f = vec4(factor);
  vec4 s = vec4(summand);
  for (int i = 0; i < rounds; ++i) {
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
    a = a * f + s; b = b * f + s; c = c * f + s; d = d * f + s;
  }
  vec4 sum = a + b + c + d;
  result[gl_GlobalInvocationID.x] = sum.x + sum.y + sum.z + sum.w;
}
)";

// The least of some calls.
double seconds_of(const gl::Program& program, int rounds) {
  glUniform1i(uniform(program, "rounds"), rounds);
  double least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kRepetitions; ++i) {
    glFinish();
    const auto begin = std::chrono::steady_clock::now();
    glDispatchCompute(static_cast<GLuint>(kWorkGroups), 1, 1);
    glFinish();
    least = std::min(least, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  gl::require_no_error();
  return least;
}

}  // namespace

double Gpu::multiply_add_gflops() {
  const gl::CurrentContext current(state_->context);
  const gl::Program program = gl::make_compute_program(kShader);
  const gl::Buffer result = gl::make_storage(nullptr, kWorkGroups * kThreadsToAWorkGroup * sizeof(float));
  glUseProgram(program.get());
  glUniform1f(uniform(program, "factor"), 0.999F);
  glUniform1f(uniform(program, "summand"), 0.001F);
  gl::bind_storage(0, result);
  // By what twice as many rounds take longer, since a call may take long in itself, and compiles what is new.
  int rounds = 1;
  double seconds = seconds_of(program, rounds);
  double more = 0;
  while (true) {
    const double doubled = seconds_of(program, 2 * rounds);
    more = doubled - seconds;
    if ((more >= kLongEnough && more >= kMostOfACall * seconds) || 4 * rounds > kMostRounds) break;
    rounds *= 2;
    seconds = doubled;
  }
  const double done = static_cast<double>(kWorkGroups * kThreadsToAWorkGroup * kMultiplyAddsToARound) * rounds;
  return 2e-9 * done / std::max(more, 1e-9);
}

}  // namespace knead::gpu
