// The long work of deform and resolve: a session applied to a shape, watched and interruptible.
#pragma once

#include <string>

#include "knead/io/shape_file.h"
#include "knead/session/replay.h"
#include "knead/session/session.h"
#include "streams.h"

namespace knead::command {

// What both subcommands read. The session has no strokes that are off. Notes go to standard error unless quiet.
struct Inputs {
  ShapeFile shape;
  Session session;
};
Inputs read_inputs(const std::string& shape, const StreamFormat& format, const std::string& session, bool quiet);

// replay(), with a progress bar unless quiet, its warnings on standard error, and options.progress set to its own.
// Returns a result whose status is done; throws Interrupted or QualityError for other statuses. The mesh must outlive
// the result.
ReplayResult replay_watched(const Mesh& mesh, const Session& session, ReplayOptions options, bool quiet);

}  // namespace knead::command
