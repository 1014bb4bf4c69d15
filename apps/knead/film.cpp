#include "film.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <thread>

#include "command.h"
#include "frames.h"
#include "knead/io.h"
#include "knead/render.h"
#include "output.h"
#include "progress_bar.h"

namespace knead::command {
namespace {

namespace fs = std::filesystem;

std::string kind_of(const std::string& output) {
  constexpr std::string_view kinds[] = {"gif", "mp4", "png", "jpg", "jpeg"};
  std::string kind = require_extension(output, kinds);
  const bool is_film = kind == "gif" || kind == "mp4";
  if (is_film != is_pattern(output)) return kind;
  throw UsageError(fmt::format(
      "--output {}: with --frames or --turntable, name a .gif or .mp4, or give a pattern for numbered pictures, as "
      "F_%04d.png",
      output));
}

// The path of a program; nothing if there is none.
std::optional<std::string> find_program(const std::string& name) {
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path == nullptr ? "" : path);
  for (std::string folder; std::getline(folders, folder, ':');) {
    const fs::path file = fs::path(folder) / name;
    if (::access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file)) return file.string();
  }
  return std::nullopt;
}

// ffmpeg, which makes a film of the pixels that it is given.
class Encoder {
 public:
  Encoder(int width, int height, double fps) {
    const std::optional<std::string> program = find_program("ffmpeg");
    std::array<int, 2> in{};
    std::array<int, 2> out{};
    if (!program || ::pipe2(in.data(), O_CLOEXEC) != 0 || ::pipe2(out.data(), O_CLOEXEC) != 0) {
      throw std::runtime_error("ffmpeg cannot be started; write a .gif, or a pattern as F_%04d.png");
    }
    std::signal(SIGPIPE, SIG_IGN);  // that it has ended is seen when it is waited for
    start(*program, in, out,
          {"ffmpeg",
           "-loglevel",
           "quiet",
           "-f",
           "rawvideo",
           "-pixel_format",
           "rgba",
           "-video_size",
           fmt::format("{}x{}", width, height),
           "-framerate",
           fmt::format("{}", fps),
           "-i",
           "pipe:0",
           "-vf",
           "pad=ceil(iw/2)*2:ceil(ih/2)*2",
           "-c:v",
           "libx264",
           "-crf",
           "20",
           "-pix_fmt",
           "yuv420p",
           "-movflags",
           "frag_keyframe+empty_moov",
           "-f",
           "mp4",
           "pipe:1"});
    input_ = in[1];
    ::close(in[0]);
    ::close(out[1]);
    reader_ = std::thread([this, from = out[0]] {
      std::array<char, 65536> block{};
      for (ssize_t count = 0; (count = ::read(from, block.data(), block.size())) > 0;) {
        film_.append(block.data(), static_cast<std::size_t>(count));
      }
      ::close(from);
    });
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;
  ~Encoder() { end(); }

  // NOLINTNEXTLINE(readability-make-member-function-const): it changes the film
  void add(const render::Image& image) {
    const std::uint8_t* at = image.pixels.data();
    std::size_t left = image.pixels.size();
    while (left > 0) {
      const ssize_t count = ::write(input_, at, left);
      if (count < 0) throw std::runtime_error("ffmpeg ended early; write a .gif, or a pattern as F_%04d.png");
      at += count;
      left -= static_cast<std::size_t>(count);
    }
  }

  // Returns the bytes of the film.
  const std::string& finish() {
    const int status = end();
    if (status != 0 || film_.empty()) {
      throw std::runtime_error(fmt::format(
          "ffmpeg failed (status {}); it may lack libx264: write a .gif, or a pattern as F_%04d.png", status));
    }
    return film_;
  }

 private:
  void start(const std::string& program, const std::array<int, 2>& in, const std::array<int, 2>& out,
             std::vector<std::string> words) {
    posix_spawn_file_actions_t actions{};
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, in[0], 0);
    posix_spawn_file_actions_adddup2(&actions, out[1], 1);
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    const int error = ::posix_spawn(&process_, program.c_str(), &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error != 0) throw std::runtime_error("ffmpeg cannot be started; write a .gif, or a pattern as F_%04d.png");
  }

  int end() {
    if (input_ < 0) return 0;
    ::close(input_);
    input_ = -1;
    reader_.join();
    int status = 0;
    ::waitpid(process_, &status, 0);
    return status;
  }

  pid_t process_ = 0;
  int input_ = -1;
  std::string film_;
  std::thread reader_;
};

// Where the pictures go.
class Film {
 public:
  explicit Film(const FilmRequest& request) : request_(request), kind_(kind_of(request.output)) {
    if (is_pattern(request.output)) {
      pattern_ = parse_frame_pattern(request.output);
    } else {
      file_.emplace(request.output);
    }
  }

  void add(const render::Image& image) {
    if (pattern_) {
      write_file_atomically(frame_path(*pattern_, next_),
                            kind_ == "png" ? render::encode_png(image) : render::encode_jpeg(image));
    } else if (kind_ == "gif") {
      if (next_ == 0) file_->write(render::gif_header(image.width, image.height));
      const auto time_of = [&](int k) { return std::lround(100 * k / request_.fps); };
      file_->write(render::gif_picture(image, next_ == 0 ? nullptr : &before_,
                                       static_cast<int>(time_of(next_ + 1) - time_of(next_))));
      before_ = image;
    } else {
      if (!encoder_) encoder_.emplace(image.width, image.height, request_.fps);
      encoder_->add(image);
    }
    ++next_;
  }

  void finish() {
    if (pattern_) return;
    file_->write(kind_ == "gif" ? render::gif_end() : encoder_->finish());
    file_->finish();
  }

 private:
  const FilmRequest& request_;
  std::string kind_;
  std::optional<FramePattern> pattern_;
  std::optional<AtomicFile> file_;
  std::optional<Encoder> encoder_;
  render::Image before_;
  int next_ = 0;
};

}  // namespace

void check_film_output(const std::string& output) {
  if (kind_of(output) == "mp4" && !find_program("ffmpeg")) {
    throw UsageError(fmt::format(
        "--output {}: needs the program ffmpeg, which is not installed; install it, or write a .gif or F_%04d.png",
        output));
  }
  require_writable(is_pattern(output) ? frame_path(parse_frame_pattern(output), 0) : output);
}

void write_film(const FilmRequest& film, bool quiet) {
  Film output(film);
  constexpr std::uint64_t each = 1000;
  Progress progress;
  ProgressBar bar(progress, each * static_cast<std::uint64_t>(film.pictures), !quiet, film.pictures);
  std::uint64_t done = 0;
  film.play([&](const PictureRequest& picture) {
    output.add(draw_image(picture, [&](double part) {
      progress.done = done + static_cast<std::uint64_t>(part * static_cast<double>(each));
    }));
    done += each;
    bar.count_frame();
  });
  output.finish();
}

}  // namespace knead::command
