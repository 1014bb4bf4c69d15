// knead deform of a point cloud in pieces.
#pragma once

#include "deform_options.h"

namespace knead::command {

// Returns whether the cloud goes through in pieces: with --stream, or where the file is larger than half of the memory
// and nothing stands against it. Throws UsageError, or what CloudPieces throws, where --stream cannot be had.
bool is_streamed(const DeformOptions& options);

// Reads the cloud twice: for the box, the decimals and the columns of the whole; then piece by piece to be moved and
// written. The file appears when all is written. The bytes are those without pieces.
void run_stream(const DeformOptions& options);

}  // namespace knead::command
