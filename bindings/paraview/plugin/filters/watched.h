// Long work in a thread: moves the progress bar of ParaView, and obeys its Abort button.
#pragma once

#include <functional>

#include "knead/error.h"

class vtkAlgorithm;

namespace knead::paraview {

// Does the work in a thread of its own, while this thread reports the progress to the filter's observers and sets
// progress.cancel if they abort. Rethrows what the work throws; throws Cancelled if it was aborted.
void run_watched(vtkAlgorithm& filter, Progress& progress, const std::function<void()>& work);

}  // namespace knead::paraview
