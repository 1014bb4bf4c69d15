// A fit: pairs of points in two views, distances, and the result as one entry.
#include "studio_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <utility>
#include <variant>

#include "gestures/gesture_kinds.h"
#include "knead/error.h"
#include "knead/io.h"

namespace knead::studio {

namespace {

constexpr std::size_t kMeasuredAtOnce = 1024;

struct Distances {
  std::vector<float> shades;
  double mean = 0;  // of the diagonal
};

struct Measured {
  double diagonal = 1;
  int threads = 0;
  const Progress* progress = nullptr;
};

// Throws Cancelled.
Distances distances_from(const SurfaceTree& tree, const Snapshot& positions, const Measured& how) {
  Distances result;
  std::vector<double> lengths(positions.size());
  parallel_for(positions.size(), kMeasuredAtOnce, how.threads, [&](std::size_t begin, std::size_t end) {
    stop_if_cancelled(how.progress);
    for (std::size_t i = begin; i < end; ++i) {
      const auto nearest = tree.closest(positions[i]);
      lengths[i] = nearest ? norm(nearest->point - positions[i]) / how.diagonal : 0;
    }
  });
  for (const double length : lengths) {
    result.shades.push_back(static_cast<float>(std::min(1.0, length / kFarFromTarget)));
    result.mean += length / static_cast<double>(lengths.size());
  }
  return result;
}

}  // namespace

void StudioFit::open(const std::filesystem::path& file, const Navigation& like) {
  document_.withdraw(Subject::opening);
  document_.post(
      [this, file, like](Document& /*document*/, Progress& /*progress*/) {
        try {
          const Mesh mesh = read_shape(file).mesh;
          if (mesh.face_count() == 0) throw InvalidInput(file.string() + ": a shape is fitted to one with faces");
          ShapeState state;
          state.mesh = std::make_shared<const Mesh>(mesh);
          state.positions = Snapshot(mesh.positions, {}, threads_);
          const std::vector<Triangle> triangles = triangulate(mesh);
          auto target = std::make_shared<const Target>(
              Target{file.filename().string(), state, Picker(state), SurfaceTree(triangles, mesh.positions)});
          document_.deliver([this, like, target = std::move(target)]() mutable {
            close();
            target_ = std::move(target);
            const Picture picture{navigation_.width, navigation_.height, navigation_.covered};
            navigation_ = like;
            const Box box = shape_box(*target_->state.mesh);
            navigation_.home = box.center();
            navigation_.width = 0;
            set_size(picture);
          });
        } catch (const Cancelled&) {
          return;
        } catch (const std::exception& error) {
          document_.tell({true, error.what(), Subject::opening});
        }
      },
      "Reading");
}

void StudioFit::close() {
  target_.reset();
  pairs_.clear();
  report_.reset();
  distances_.clear();
  fitted_ = {};
  asked_ = {};
}

Screen StudioFit::screen() const { return {camera_of(navigation_.view), navigation_.width, navigation_.height}; }

void StudioFit::set_size(const Picture& picture) {
  if (navigation_.width == picture.width && navigation_.height == picture.height &&
      navigation_.covered == picture.covered) {
    return;
  }
  navigate(navigation_, Resized{picture.width, picture.height});
  navigation_.covered = picture.covered;
  if (is_open()) navigation_.view = framed(navigation_.view, shape_box(*target_->state.mesh), picture);
}

void StudioFit::handle(const Event& event) {
  if (navigate(navigation_, event)) return;
  const auto* const button = std::get_if<ButtonChanged>(&event);
  if (button == nullptr || !button->down || button->button != MouseButton::left) return;
  const auto hit = target_->picker.pick(ray_through(screen(), button->x, button->y), target_->state);
  if (!hit) return begin_orbit(navigation_, *button);
  choose(target_->picker.vertex_of(*hit, target_->state), true);
}

bool StudioFit::choose(const Pointer& pointer, const GestureContext& around) {
  if (around.picker == nullptr) return false;
  const auto hit = hit_at(pointer, around);
  if (!hit) return false;
  pairs_mesh_ = around.state.mesh;
  choose(around.picker->vertex_of(*hit, around.state), false);
  return true;
}

void StudioFit::choose(std::uint32_t vertex, bool is_target) {
  const bool is_begun = !pairs_.empty() && !(pairs_.back().source && pairs_.back().target);
  if (!is_begun) pairs_.emplace_back();
  (is_target ? pairs_.back().target : pairs_.back().source) = vertex;
}

std::size_t StudioFit::complete_pairs() const {
  return static_cast<std::size_t>(
      std::count_if(pairs_.begin(), pairs_.end(), [](const ClickedPair& pair) { return pair.source && pair.target; }));
}

bool StudioFit::set_pairs(std::vector<ClickedPair> pairs) {
  const ShapeState& shape = document_.shown().state;
  const bool are_known = std::all_of(pairs.begin(), pairs.end(), [&](const ClickedPair& pair) {
    return pair.source.value_or(0) < shape.positions.size() && pair.target.value_or(0) < target().positions.size();
  });
  if (!are_known) return false;
  pairs_ = std::move(pairs);
  pairs_mesh_ = shape.mesh;
  return true;
}

void StudioFit::remove_last_pair() {
  if (!pairs_.empty()) pairs_.pop_back();
}

void StudioFit::run() {
  const DocumentState& shown = document_.shown();
  if (!is_open() || shown.opened == 0) return;
  document_.withdraw(Subject::strokes);
  if (shown.looked_at || !shown.state.mask.is_empty()) {
    const char* const why = shown.looked_at ? "A fit begins from the present shape: click on the shape to return to it."
                                            : "A fit moves the whole shape: clear the mask first.";
    document_.tell({true, why, Subject::strokes});
    return;
  }
  BodyFitOptions options;
  for (const ClickedPair& pair : pairs_) {
    if (!pair.source || !pair.target) continue;
    options.landmarks.push_back({shown.state.positions[*pair.source], target().positions[*pair.target]});
  }
  options.surface = settings_.surface;
  options.volume = settings_.grows ? FitVolume::free : FitVolume::keep;
  options.threads = threads_;
  document_.post(
      [this, options, state = shown.state, objects = shown.objects, target = target_](Document& document,
                                                                                      Progress& progress) mutable {
        try {
          options.progress = &progress;
          BodyFit fit = fit_body(active_mesh(objects, state), *target->state.mesh, options);
          std::vector<SessionStroke> strokes(fit.strokes.size());
          for (std::size_t i = 0; i < strokes.size(); ++i) {
            strokes[i].stroke = std::move(fit.strokes[i]);
            strokes[i].name = fmt::format("Fit to {}", target->name);
          }
          if (strokes.empty()) {
            document_.tell({false, "The shape is where the target is: there is nothing to fit."});
            return;
          }
          document.set_live(std::move(strokes), progress);
          document.finish(progress);
          const std::string complaint = complaint_about(fit.report, options);
          if (!complaint.empty()) {
            document_.tell(
                {true, "The fit is not sound, undo takes it back. " + in_words(complaint), Subject::strokes});
          }
          document_.deliver([this, report = std::move(fit.report)] {
            report_ = report;
            fitted_ = document_.shown().state;
          });
        } catch (const Cancelled&) {
          return;
        } catch (const std::exception& error) {
          document_.tell({true, "The shape cannot be fitted. " + in_words(error.what()), Subject::strokes});
        }
      },
      "Fitting");
}

void StudioFit::follow(bool has_gesture) {
  if (!is_open()) return;
  const DocumentState& shown = document_.shown();
  if (pairs_mesh_ != nullptr && pairs_mesh_ != shown.state.mesh) pairs_.clear();
  pairs_mesh_ = shown.state.mesh;
  if (report_ && !fitted_.is_same(shown.state)) report_.reset();
  if (has_gesture || shown.opened == 0 || (asked_.mesh != nullptr && asked_.is_same(shown.state))) return;
  asked_ = shown.state;
  document_.post([this, state = shown.state, diagonal = shown.diagonal, target = target_](Document& /*document*/,
                                                                                          Progress& progress) {
    Distances found;
    try {
      found = distances_from(target->tree, state.positions, {diagonal, threads_, &progress});
    } catch (const Cancelled&) {  // no colour is better than that of another shape
      found = {};
    }
    document_.deliver([this, found = std::move(found)] {
      distances_ = found.shades;
      mean_distance_ = found.mean;
      ++measured_;
    });
  });
}

}  // namespace knead::studio
