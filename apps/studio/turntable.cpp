#include "turntable.h"

#include <fmt/format.h>

#include <numbers>
#include <string>

#include "knead/error.h"
#include "studio.h"

namespace knead::studio {

Turntable make_turntable(const std::filesystem::path& pattern, int pictures, const View& view) {
  if (pattern.extension() != ".png") throw InvalidInput("The pictures are PNG files: give a name like turn.png");
  if (pictures < 2 || pictures > kMaxTurntablePictures) {
    throw InvalidInput(fmt::format("A turntable has 2 to {} pictures, not {}.", kMaxTurntablePictures, pictures));
  }
  return {numbered(pattern), pictures, 0, view};
}

View view_of(const Turntable& turntable) {
  View view = turntable.start;
  view.yaw += 2 * std::numbers::pi * turntable.next / turntable.pictures;
  return view;
}

std::filesystem::path file_of(const Turntable& turntable) {
  std::string name = turntable.pattern.filename().string();
  name.replace(name.find(kNumber), 4, fmt::format("{:04}", turntable.next));
  return turntable.pattern.parent_path() / name;
}

void Studio::record_turntable(const std::filesystem::path& pattern, int pictures) {
  if (shown_.opened == 0) return;
  try {
    turntable_ = make_turntable(pattern, pictures, navigation_.view);
  } catch (const InvalidInput& error) {
    tell({true, error.what()});
  }
}

bool Studio::step_turntable(const std::function<void(const std::filesystem::path&)>& write) {
  if (!turntable_) return false;
  navigation_.view = view_of(*turntable_);
  try {
    write(file_of(*turntable_));
  } catch (const std::exception& error) {
    tell({true, error.what()});
    stop_turntable();
    return false;
  }
  if (++turntable_->next < turntable_->pictures) return true;
  tell({false, fmt::format("Recorded {} pictures.", turntable_->pictures)});
  stop_turntable();
  return false;
}

void Studio::stop_turntable() {
  if (!turntable_) return;
  if (turntable_->next < turntable_->pictures) {
    tell({false,
          fmt::format("The recording was stopped after {} of {} pictures.", turntable_->next, turntable_->pictures)});
  }
  navigation_.view = turntable_->start;
  turntable_.reset();
}

}  // namespace knead::studio
