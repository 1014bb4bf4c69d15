// The paper's scenes on a GPU, beside the CPU in the same run.
#pragma once

#include <vector>

#include "bench_scenes.h"
#include "knead/io/json.h"

namespace knead::command {

// Measures the scenes one after the other, and on a real GPU the paper's benchmark on ten million vertices if `all`;
// prints each row as soon as it is there unless quiet. Throws GpuError where there is no GPU.
Json measure_on_gpu(std::vector<BenchScene> scenes, bool all, bool quiet);

}  // namespace knead::command
