// The command line of `knead deform`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "command.h"
#include "frames.h"
#include "knead/replay.h"
#include "remesh_options.h"
#include "streams.h"

namespace knead::command {

struct DeformOptions {
  std::string shape;
  std::string session;
  std::string output;
  double tolerance = 1e-5;
  std::string integrator = "tsit5";
  std::string precision = "float";
  std::string backend = "cpu";
  std::optional<int> threads;
  bool inverse = false;
  bool check = false;
  std::optional<std::string> require;
  RemeshFlags remesh;
  std::optional<double> until;
  FrameFlags frames;
  std::string report;
  std::string digits = "auto";
  bool stream = false;
  double piece_mb = 32;
  StreamFormat format;
  CommonOptions common;
};

// The value of --digits.
enum class DigitsKind { automatic, shortest, given };
struct Digits {
  DigitsKind kind = DigitsKind::automatic;
  int count = 0;  // if given
};

// Throws UsageError for values out of range, and for rounding beside a certificate.
Digits digits_of(const DeformOptions& options);

// Returns WriteOptions::decimals for an output like the source. Automatic: as many as the source's coordinates have, if
// half a unit of the last is within the tolerance (relative to the diagonal of the box).
std::optional<int> decimals_for(const Digits& digits, const ShapeFile& source, double tolerance);
// The same for coordinates with `own` decimals (nothing: not text) in a box of that diagonal.
std::optional<int> decimals_for(const Digits& digits, std::optional<int> own, double diagonal, double tolerance);

// Throws UsageError where --until is beyond the session.
void check_until(const DeformOptions& options, const Session& session);

// The options of the subcommand, whose values go to `options`.
std::vector<Option> describe(DeformOptions& options);

// Throws UsageError for values out of range.
ReplayOptions replay_options(const DeformOptions& options);

}  // namespace knead::command
