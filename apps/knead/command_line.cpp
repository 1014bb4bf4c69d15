// Reads the command line, runs one subcommand, and turns every failure into one line and an exit code. `knead` and
// `knead-bench` share it.

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "command.h"
#include "knead/error.h"
#include "knead/knead.h"
#include "knead/remesh.h"
#include "output.h"
#include "program.h"

namespace knead::command {

namespace {

// Lays out the help. CLI11's own layout differs between versions, and manual pages are made from the printed help.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const override {
    const auto options = app->get_options([](const CLI::Option* o) { return o->nonpositional(); });
    const auto positionals = app->get_options([](const CLI::Option* o) { return o->get_positional(); });
    const auto subcommands = app->get_subcommands([](const CLI::App*) { return true; });
    std::string usage = name + (options.empty() ? "" : " [OPTIONS]");
    for (const CLI::Option* o : positionals) usage += ' ' + make_option_usage(o);
    if (!subcommands.empty()) usage += " SUBCOMMAND";
    std::string text = fmt::format("{}\nUsage: {}\n", app->get_description(), usage);
    if (!positionals.empty()) text += "\nPositionals:\n";
    for (const CLI::Option* o : positionals) text += row(o->get_name(true) + form_of(*o), o->get_description());
    text += "\nOptions:\n";
    for (const CLI::Option* o : options) text += row(o->get_name(false, true) + form_of(*o), o->get_description());
    if (!subcommands.empty()) text += "\nSubcommands:\n";
    for (const CLI::App* s : subcommands) text += row(s->get_name(), s->get_description());
    return text + "\n" + app->get_footer() + "\n";
  }

 private:
  // The text after an option's names.
  static std::string form_of(const CLI::Option& option) {
    if (option.get_type_size() == 0) return {};
    std::string text;
    if (!option.get_type_name().empty()) text += ' ' + option.get_type_name();
    if (!option.get_default_str().empty()) text += '=' + option.get_default_str();
    if (option.get_expected_max() == CLI::detail::expected_max_vector_size) text += " ...";
    return text + (option.get_required() ? " REQUIRED" : "");
  }
  static std::string row(const std::string& names, const std::string& description) {
    constexpr std::size_t width = 28;
    return fmt::format("  {:<{}}{}{}\n", names, width, names.size() < width ? "" : "\n" + std::string(width + 2, ' '),
                       description);
  }
};

void add_examples(CLI::App& app, const std::string& examples) { app.footer("Examples:\n" + examples); }
// Returns the long name of an option: "--vertices" of "-n,--vertices".
std::string long_name(const Option& option) { return option.name.substr(option.name.rfind(',') + 1); }

// Returns words as a list: "first, each or none".
std::string listed(const std::vector<std::string>& words) {
  return fmt::format("{} or {}", fmt::join(words.begin(), words.end() - 1, ", "), words.back());
}

// Adds an option, and its value before parsing to the help.
struct AddOption {
  CLI::App& app;
  const Option& option;

  CLI::Option* operator()(bool* target) const { return app.add_flag(option.name, *target, option.help); }
  // One value each time that an option of several is given: what follows may be an argument.
  CLI::Option* operator()(std::vector<std::string>* target) const {
    CLI::Option* const added = app.add_option(option.name, *target, option.help);
    return option.name.starts_with('-') ? added->allow_extra_args(false) : added;
  }
  CLI::Option* operator()(const WordTarget& target) const {
    const auto choose = [target, name = long_name(option)](const std::string& word) {
      const auto found = std::ranges::find(target.words, word);
      if (found == target.words.end()) throw UsageError(fmt::format("{} {}: say {}", name, word, listed(target.words)));
      target.choose(static_cast<std::size_t>(found - target.words.begin()));
    };
    CLI::Option* const added = app.add_option_function<std::string>(option.name, choose, option.help);
    return option.kind == OptionKind::with_default ? added->default_str(target.words[target.chosen]) : added;
  }
  template <class T>
  CLI::Option* operator()(T* target) const {
    CLI::Option* const added = app.add_option(option.name, *target, option.help);
    return option.kind == OptionKind::with_default ? added->capture_default_str() : added;
  }
};

// Throws UsageError for a number that the option does not accept; the parser refuses other texts.
CLI::Validator only_accepted(const Option& option) {
  const auto check = [option](const std::string& text) {
    double number = 0;
    if (!CLI::detail::lexical_cast(text, number) || option.accepts(number)) return std::string();
    throw UsageError(fmt::format("{} {}: {}", long_name(option), text, option.advice));
  };
  return {check, ""};
}

// Returns the message on an option or argument with an empty value, as in --until ''.
CLI::Validator not_empty() {
  const auto check = [](const std::string& value) {
    return value.empty() ? std::string("its value is empty; give one, or leave it out") : std::string();
  };
  return {check, ""};
}

void add_subcommand(CLI::App& parent, const Subcommand& subcommand) {
  CLI::App& app = *parent.add_subcommand(subcommand.name, subcommand.help);
  for (const Option& option : subcommand.options) {
    CLI::Option& added = *std::visit(AddOption{app, option}, option.target);
    if (option.kind == OptionKind::required) added.required();
    if (std::holds_alternative<bool*>(option.target)) continue;
    added.type_name(option.value_name);
    if (option.accepts) added.check(only_accepted(option));
    added.check(not_empty());
  }
  add_examples(app, subcommand.examples);
}

int fail(ExitCode code, const std::string& message) {
  print_message(message);
  return code;
}

int run_subcommand(const Subcommand& subcommand) {
  try {
    subcommand.run();
    return kDone;
  } catch (const UsageError& error) {
    return fail(kWrongUsage, std::string(error.what()) + " (see knead " + subcommand.name + " --help)");
  } catch (const QualityError& error) {
    return fail(kQualityNotMet, error.what());
  } catch (const QualityLimit& error) {
    return fail(kQualityNotMet, error.what());
  } catch (const InvalidInput& error) {
    return fail(kInvalidInput, error.what());
  } catch (const IoError& error) {
    return fail(error.operation() == IoError::Operation::write ? kOutputFailed : kInvalidInput, error.what());
  } catch (const Interrupted&) {
    return fail(kInterrupted, "interrupted");
  }
}

// Throws UsageError if the first word is not a subcommand. The parser's own message would be about unexpected
// arguments.
void check_first_word(int argc, char** argv, const std::vector<Subcommand>& subcommands) {
  std::string names;
  for (const Subcommand& each : subcommands) names += (names.empty() ? "" : ", ") + each.name;
  if (argc < 2) throw UsageError("no command given; say one of " + names);
  const std::string word = argv[1];
  if (word.starts_with('-') && word != "-" && word != "--") return;
  const auto is_named = [&](const Subcommand& each) { return each.name == word; };
  if (std::any_of(subcommands.begin(), subcommands.end(), is_named)) return;
  throw UsageError("no command '" + word + "'; say one of " + names);
}

// Returns the command line that prints the help of the chosen subcommand, or of the command.
std::string help_of(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return "knead " + (chosen.empty() ? "" : chosen.front()->get_name() + " ") + "--help";
}

// Describes the first wrong word. The parser would list everything after a wrong option, including its value.
std::string unexpected_word(const CLI::App& app) {
  std::vector<std::string> words = app.remaining(true);
  std::erase(words, "--");
  if (words.empty()) return "too many arguments";
  const auto option = std::find_if(words.begin(), words.end(), [](const auto& word) { return word.starts_with('-'); });
  if (option != words.end()) return "no option " + *option;
  return "'" + words.front() + "' is one argument too many";
}

int run(int argc, char** argv, const std::vector<Subcommand>& subcommands) {
  CLI::App app("Deforms 3D shapes by divergence-free vector fields, which keep volume and never fold space.", "knead");
  app.formatter(std::make_shared<HelpFormatter>());
  app.set_version_flag("--version", "knead " KNEAD_VERSION);
  app.require_subcommand(1);
  add_examples(app,
               "  knead make hand -o hand.ply\n"
               "  knead deform hand.ply bend.knead -o bent.ply\n"
               "  knead COMMAND --help");
  for (const Subcommand& subcommand : subcommands) add_subcommand(app, subcommand);
  try {
    check_first_word(argc, argv, subcommands);
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    print(app.help());
    return kDone;
  } catch (const CLI::CallForVersion&) {
    print(app.version() + "\n");
    return kDone;
  } catch (const CLI::ExtrasError&) {
    return fail(kWrongUsage, unexpected_word(app) + "; see " + help_of(app));
  } catch (const CLI::ParseError& error) {
    return fail(kWrongUsage, error.what() + ("; see " + help_of(app)));
  } catch (const UsageError& error) {
    return fail(kWrongUsage, error.what() + (" (see " + help_of(app) + ")"));
  }
  const std::string chosen = app.get_subcommands().front()->get_name();
  return run_subcommand(*std::ranges::find(subcommands, chosen, &Subcommand::name));
}

// With less, the main thread or those of the library end in a segmentation fault; 96 KiB were enough.
void require_stack() {
  constexpr std::uint64_t least = 256 << 10;
  const std::uint64_t limit = stack_bytes();
  if (limit >= least) return;
  throw std::runtime_error(
      fmt::format("the stack is limited to {} KiB; allow at least {}: ulimit -s {}", limit >> 10, least >> 10, 8192));
}

}  // namespace

void add_common_options(std::vector<Option>& options, CommonOptions& common) {
  options.push_back({"-q,--quiet", &common.quiet, "Print only errors, and what --json or --report ask for"});
  options.push_back({"--json", &common.json, "Print the result as one JSON object on standard output"});
}

void add_threads_option(std::vector<Option>& options, int& threads) {
  constexpr int most = 1024;  // as many as the largest machines have
  options.push_back({"--threads", &threads, "Number of threads (default: all); does not change the result", "N",
                     OptionKind::optional, from_to(1, most),
                     fmt::format("give 1 to {}, or leave it out to use all", most)});
}

void check_backend(const std::string& name) {
#ifdef KNEAD_HAS_GPU
  if (name != "cpu" && name != "gpu") throw UsageError(fmt::format("--backend {}: say cpu or gpu", name));
#else
  if (name == "gpu") throw UsageError("this build has no GPU backend; leave --backend out");
  if (name != "cpu") throw UsageError(fmt::format("--backend {}: say cpu", name));
#endif
}

Subcommand bench_subcommand(std::function<void(const BenchOptions&)> run) {
  const auto options = std::make_shared<BenchOptions>();
  std::vector<Option> described{
      {"--mesh", &options->meshes, "Run the paper's benchmark on this shape instead; may be repeated", "FILE"},
      {"--integrators", &options->integrators,
       "Instead, measure error and time of every integrator and tolerance, for a stroke of each tool"},
      {"--backend", &options->backend, "gpu: run the paper's scenes on a GPU instead", "NAME",
       OptionKind::with_default},
      {"-n,--vertices", &options->vertices, "With --backend gpu: run on a procedural knot of about N vertices", "N"},
  };
  add_common_options(described, options->common);
  return {"bench", "Measure how fast shapes are deformed on this machine", described,
          "  knead bench\n"
          "  knead bench --integrators\n"
          "  knead bench --backend gpu\n"
          "  knead bench --backend gpu -n 10000000\n"
          "  knead bench --json --mesh scan.ply --mesh cloud.xyz\n"
          "The benchmark reads scans of the paper's shapes from $KNEAD_MESHES, or ../shared/meshes. Without them,\n"
          "it uses procedural shapes of the same size.",
          [options, run = std::move(run)] { run(*options); }};
}

int run_program(int argc, char** argv, const std::vector<Subcommand>& subcommands) {
  try {
    prepare_process();
    handle_interruptions();
    require_stack();
    return run(argc, argv, subcommands);
  } catch (const ClosedPipe&) {
    return kOutputFailed;  // the reader, as `head`, has enough; no message is needed
  } catch (const IoError& error) {
    print_message(error.what());
    return kOutputFailed;
  } catch (const std::bad_alloc&) {
    print_message("out of memory; try a smaller shape or close other programs");
  } catch (const std::exception& error) {
    print_message(error.what());
  } catch (...) {
    print_message("unknown failure; please report it");
  }
  return kInternalError;
}

}  // namespace knead::command
