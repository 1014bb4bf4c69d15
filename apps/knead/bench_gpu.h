// `knead bench --backend gpu`: the paper's scenes on a GPU and on the CPU in the same run.
#pragma once

#include <vector>

#include "bench_scenes.h"
#include "knead/io.h"

namespace knead::command {

// Measures the scenes one after the other. If `all`, a real GPU also runs the paper's benchmark on ten million
// vertices. Prints each row as soon as it is measured, unless quiet. Throws GpuError if there is no GPU.
Json measure_on_gpu(std::vector<BenchScene> scenes, bool all, bool quiet);

}  // namespace knead::command
