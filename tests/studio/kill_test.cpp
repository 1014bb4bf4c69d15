// Studio is killed at random moments; what the next start gives back is compared with what was there.
//
// KNEAD_KILLS: how many times (12). A full run is 200.
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "kill_script.h"
#include "studio.h"

extern char** environ;

namespace knead::studio::kill_test {
namespace {

namespace fs = std::filesystem;

constexpr double kPause = 0.001;  // seconds between the driver's events
constexpr double kRun = 0.8;      // seconds that a whole run takes, about

pid_t start_driver(const fs::path& state, const fs::path& output, const char* threads, double pause) {
  const std::string pause_text = fmt::format("{}", pause);
  std::string program = KNEAD_KILL_DRIVER;
  std::string folder = state.string();
  std::string mode = threads;
  std::string waiting = pause_text;
  char* arguments[] = {program.data(), folder.data(), mode.data(), waiting.data(), nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  pid_t process = 0;
  const int error = posix_spawn(&process, program.c_str(), &actions, nullptr, arguments, environ);
  posix_spawn_file_actions_destroy(&actions);
  EXPECT_EQ(error, 0);
  return process;
}

// The hashes in the order in which they were printed; an incomplete last line is left out.
std::vector<std::string> batches_in(const fs::path& output) {
  std::ifstream file(output);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::string> result;
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    result.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return result;
}

std::string recovered(const fs::path& state) {
  Studio studio({state / "config", state, false, 1});
  if (studio.document().abandoned().empty()) return "nothing";
  EXPECT_EQ(studio.document().abandoned().size(), 1u);
  studio.document().recover(studio.document().abandoned().front().folder);
  for (const Notice& notice : studio.document().take_notices()) EXPECT_FALSE(notice.is_error) << notice.text;
  std::string result = test::batch_line(studio.document().shown().state.positions);
  studio.document().close();
  return result;
}

// For each number of batches after which a person may be in the middle of the remeshed drag: the shape if she let go
// there. Half a drag comes back as one remeshed stroke, while a drag shows its pieces before they are remeshed as one.
std::map<std::size_t, std::string> let_go(const fs::path& folder) {
  const std::string script = test::kKillScript;
  std::map<std::size_t, std::string> result;
  for (std::size_t at = script.rfind("{\"press\""); script[at + 2] != 'r'; at = script.find('\n', at) + 1) {
    const std::size_t line_end = script.find('\n', at);
    const fs::path state = folder / "let_go";
    Studio studio({state / "config", state, false, 1});
    std::size_t batches = 0;
    test::run_batches(studio, script.substr(0, line_end + 1), 0, [&](const std::string&) { ++batches; });
    const std::string place = script.substr(script.find('[', at), line_end - script.find('[', at));
    test::run_batches(studio, "{\"release\": " + place + "\n", 0,
                      [&](const std::string& batch) { result[batches] = batch; });
    studio.document().close();
    fs::remove_all(state);
  }
  return result;
}

int kills() {
  const char* wanted = std::getenv("KNEAD_KILLS");
  return wanted != nullptr ? std::max(1, std::atoi(wanted)) : 12;
}

class Kill : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("knead_kill_test_{}", ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::vector<std::string> whole_run() const {
    const pid_t process = start_driver(folder_ / "whole", folder_ / "whole.txt", "no-thread", 0);
    int status = 0;
    ::waitpid(process, &status, 0);
    EXPECT_EQ(status, 0);
    return batches_in(folder_ / "whole.txt");
  }

  void kill_after(double seconds, const fs::path& state, const fs::path& output, const char* threads) const {
    const pid_t process = start_driver(state, output, threads, kPause);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    ::kill(process, SIGKILL);
    int status = 0;
    ::waitpid(process, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status)) << "the driver had ended before it was killed";
  }

  fs::path folder_;
};

TEST_F(Kill, LosesNothingButTheBatchUnderWay) {
  const std::vector<std::string> all = whole_run();
  ASSERT_GT(all.size(), 100u);
  const std::map<std::size_t, std::string> remeshed = let_go(folder_);
  ASSERT_GT(remeshed.size(), 3u);
  const auto is_after = [&](const std::string& back, std::size_t batches) {
    const auto found = remeshed.find(batches);
    if (found != remeshed.end() && back == found->second) return true;
    return batches <= all.size() && back == all[batches - 1];
  };
  std::mt19937 random(7);
  std::uniform_real_distribution<double> moment(0.01, kRun);
  std::size_t early = 0;
  std::size_t latest = 0;
  for (int i = 0; i < kills(); ++i) {
    const fs::path state = folder_ / fmt::format("state{}", i);
    const fs::path output = folder_ / fmt::format("out{}.txt", i);
    kill_after(moment(random), state, output, "no-thread");
    const std::vector<std::string> seen = batches_in(output);
    latest = std::max(latest, seen.size());
    ASSERT_LE(seen.size(), all.size());
    ASSERT_TRUE(std::equal(seen.begin(), seen.end(), all.begin())) << "runs are the same";
    const std::string back = recovered(state);
    if (seen.empty()) {
      ++early;  // before the shape was open, or just then
      EXPECT_TRUE(back == "nothing" || back == all[0]) << back;
    } else {
      // The last batch that was told, or the one that had been written but not told.
      EXPECT_TRUE(is_after(back, seen.size()) || is_after(back, seen.size() + 1))
          << "kill " << i << " after batch " << seen.size() << " of " << all.size();
    }
    fs::remove_all(state);
  }
  fmt::print("{} kills, {} before the shape was open, the latest after batch {} of {}\n", kills(), early, latest,
             all.size());
  EXPECT_LT(early, static_cast<std::size_t>(kills()));
}

// With the worker, pointer samples are merged as time goes: runs differ, and only what was told can be compared.
TEST_F(Kill, LosesNothingThatWasToldWithTheWorkerEither) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> moment(0.05, kRun);
  int same = 0;
  for (int i = 0; i < kills(); ++i) {
    const fs::path state = folder_ / fmt::format("state{}", i);
    const fs::path output = folder_ / fmt::format("out{}.txt", i);
    kill_after(moment(random), state, output, "thread");
    const std::vector<std::string> seen = batches_in(output);
    const std::string back = recovered(state);
    EXPECT_TRUE(seen.empty() || back != "nothing");
    if (seen.empty() || back == seen.back()) ++same;
    fs::remove_all(state);
  }
  // What is not the same was written after the last batch that was told: a matter of a millisecond.
  EXPECT_GT(same, 0);
  fmt::print("{} kills, {} right after a batch that was told\n", kills(), same);
}

}  // namespace
}  // namespace knead::studio::kill_test
