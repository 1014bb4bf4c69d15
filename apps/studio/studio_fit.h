// Fits the shape to another one: the target and its view, pairs of points, and the distances between both shapes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gestures/gesture.h"
#include "gestures/navigation.h"
#include "gestures/picker.h"
#include "knead/fit.h"
#include "knead/mesh.h"
#include "studio_document.h"

namespace knead::studio {

// A vertex of the shape and one of the target; nothing for one that has not been clicked yet.
struct ClickedPair {
  std::optional<std::uint32_t> source;
  std::optional<std::uint32_t> target;
};

// The settings of a fit, besides its pairs.
struct FitSettings {
  bool grows = false;   // FitVolume::free in the place of keep
  bool surface = true;  // the whole surface, not the pairs alone
};

// The distance that is drawn in the last colour, of the diagonal of the shape.
inline constexpr double kFarFromTarget = 0.03;

class StudioFit {
 public:
  StudioFit(StudioDocument& document, int threads) : document_(document), threads_(threads) {}

  // Reads the target and opens its view, with the direction of `like`; a notice says if it cannot be read. close()
  // drops the target.
  void open(const std::filesystem::path& file, const Navigation& like);
  void close();
  bool is_open() const { return target_ != nullptr; }

  // The following functions need an open fit.
  const ShapeState& target() const { return target_->state; }
  const std::string& name() const { return target_->name; }
  FitSettings& settings() { return settings_; }

  // The view of the target. Places of events are pixels of this view.
  Screen screen() const;
  void set_size(const Picture& picture);
  void handle(const Event& event);
  bool is_turning() const { return navigation_.drag != NavigationDrag::none; }

  // Adds the point of the shape under the pointer to the incomplete pair, or begins a pair. Returns false without a
  // point.
  bool choose(const Pointer& pointer, const GestureContext& around);
  const std::vector<ClickedPair>& pairs() const { return pairs_; }
  std::size_t complete_pairs() const;
  // Replaces all pairs. Returns false, and changes nothing, if a shape has no such vertex.
  bool set_pairs(std::vector<ClickedPair> pairs);
  void remove_last_pair();
  void clear_pairs() { pairs_.clear(); }

  // Fits the shape to the target, as one entry of the history. A notice says what is wrong with the result, or why the
  // shape cannot be fitted as it is: a mask acts, or the past is looked at.
  void run();
  // Returns the report of the last fit while the shape is its result.
  const std::optional<BodyFitReport>& report() const { return report_; }

  // Adapts to the document: measures distances if the shape has changed, and drops the pairs if it has other faces.
  void follow(bool has_gesture);
  // Returns the distance of each vertex from the target, divided by kFarFromTarget and at most 1; empty until measured.
  const std::vector<float>& distances() const { return distances_; }
  std::uint64_t measured() const { return measured_; }     // grows with every measurement
  double mean_distance() const { return mean_distance_; }  // of the diagonal

 private:
  struct Target {
    std::string name;
    ShapeState state;
    Picker picker;
    SurfaceTree tree;
  };

  void choose(std::uint32_t vertex, bool is_target);

  StudioDocument& document_;
  int threads_;
  std::shared_ptr<const Target> target_;
  Navigation navigation_;
  FitSettings settings_;
  std::vector<ClickedPair> pairs_;
  std::shared_ptr<const Mesh> pairs_mesh_;  // whose vertices they are
  std::optional<BodyFitReport> report_;
  ShapeState fitted_;  // the shape that it made
  ShapeState asked_;   // the shape whose distances were asked for
  std::uint64_t measured_ = 0;
  std::vector<float> distances_;
  double mean_distance_ = 0;
};

}  // namespace knead::studio
