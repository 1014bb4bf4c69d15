// Studio on a page. The page calls main() once its stored files are there, and shows what goes wrong.
#include <emscripten.h>

#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <string>

#include "application.h"

EM_JS(void, page_fail, (const char* line), { Module.page.fail(UTF8ToString(line)); });
EM_JS(void, page_tell, (const char* line), { Module.page.tell(UTF8ToString(line)); });
EM_JS(void, page_end, (), { Module.page.end(); });

namespace {

using knead::studio::SteppedApplication;

std::unique_ptr<SteppedApplication>& application() {
  static std::unique_ptr<SteppedApplication> the;
  return the;
}

void fail(const char* line) {
  emscripten_cancel_main_loop();
  page_fail(line);
}

// Runs a function; what it throws ends the application with one line. The journal has all strokes.
template <class Function>
void guarded(Function function) {
  try {
    function();
  } catch (const std::bad_alloc&) {
    fail("The browser has too little memory for this shape. Your strokes are stored: reload the page to recover them.");
  } catch (const std::exception& error) {
    fail(error.what());
  }
}

// The page repeats Studio's messages for readers of the screen.
void tell_messages() {
  static std::string told;
  const std::string message = application()->message();
  if (message == told) return;
  told = message;
  page_tell(told.c_str());
}

void step() {
  guarded([] {
    if (application()->step()) return tell_messages();
    emscripten_cancel_main_loop();
    page_end();
  });
}

}  // namespace

int main() {
  guarded([] {
    std::error_code error;
    std::filesystem::create_directories("/home/web_user/files", error);
    std::filesystem::current_path("/home/web_user/files", error);
    application() = std::make_unique<SteppedApplication>(knead::studio::ApplicationOptions{});
    emscripten_set_main_loop(step, 0, 0);
  });
  return 0;
}
