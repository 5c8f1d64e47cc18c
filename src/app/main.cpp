// The command: a thin layer that reads arguments, owns MPI and PETSc, and turns errors into exit codes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <new>
#include <optional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "app/doc.hpp"
#include "app/interrupts.hpp"
#include "app/json_schema.hpp"
#include "app/run.hpp"
#include "app/say.hpp"
#include "app/schema.hpp"
#include "app/verbs.hpp"
#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "base/single_process.hpp"
#include "base/terminal.hpp"
#include "base/units.hpp"
#include "output/checkpoint.hpp"
#include "output/report.hpp"

namespace {

using namespace calor;

/// A time by the clock in s: "90s", "3h", "30 min", or a number of seconds.
double time_of(const std::string& text) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789."), text.size());
  const std::size_t unit = std::min(text.find_first_not_of(' ', digits), text.size());
  try {
    const double time = std::stod(text.substr(0, digits));
    const double s = unit < text.size() ? to_si(time, text.substr(unit), "s") : time;
    if (s > 0) return s;
  } catch (const std::exception&) {
  }
  throw CLI::ValidationError("--time-limit", fmt::format("'{}' is no time: write it as in 90s, 30min or 3h", text));
}

struct CommandLine {
  std::string case_file, folder, json, name, from, key;
  std::vector<std::string> overrides, paths, words;  // words: all of them, without -j
  std::optional<double> time_limit;                  // s
  int ranks = 1;
  bool quiet = false, restart = false, as_schema = false, numbers = false;
};

int show_help(CLI::App& app, const std::string& verb) {
  if (verb.empty()) {  // help() of an app is that of the verb it was called with
    say(app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
    return 0;
  }
  for (const CLI::App* known : app.get_subcommands({}))
    if (known->get_name() == verb) {
      say(known->help("calor"));
      return 0;
    }
  throw Error(Fault::command, fmt::format("there is no verb '{}'", verb), "calor help lists them");
}

std::string folder_of(const CommandLine& a, const Case& c) {
  return a.folder.empty() ? "results/" + c.name() : a.folder;
}

/// What a run that did not come to its end has left.
std::string left_in(const std::string& folder) {
  const auto at = newest_checkpoint(folder);
  return at ? fmt::format("{} holds the results so far; --restart goes on from {}", folder, *at)
            : fmt::format("there is no checkpoint in {} to go on from", folder);
}

int run_verb(const CommandLine& a, MPI_Comm comm) {
  const Case c = Case::read(a.case_file, schema(), a.overrides);
  const std::string folder = folder_of(a, c);
  catch_interrupts(rank_of(comm));
  std::signal(SIGPIPE, SIG_IGN);  // who reads the output may go away: the results are what counts
  std::vector<std::string> command{"calor"};
  command.insert(command.end(), a.words.begin(), a.words.end());
  const RunResult result =
      run(c, comm,
          {.folder = folder, .quiet = a.quiet, .restart = a.restart, .time_limit = a.time_limit, .command = command});
  if (rank_of(comm) == 0) {
    const TemperatureUnit unit = TemperatureUnit::of(c);
    if (!a.quiet) say(fmt::format("{}\n", fmt::join(summary(result, unit), "\n")));
    for (const Verdict& v : result.verdicts)
      if (!a.quiet || !v.passed) say(line(v, unit, stdout_takes_colour()) + "\n");
    if (result.is_cut_short()) {
      complain(fmt::format("calor: {}: {}",
                           result.interrupted_by ? fmt::format("interrupted by signal {}", result.interrupted_by)
                                                 : "the time limit is over",
                           left_in(folder)));
    } else if (!a.quiet) {
      say(fmt::format("results      {}\n", folder));
      say(fmt::format("next         calor report {}\n", folder));
    }
  }
  if (result.interrupted_by) return 128 + result.interrupted_by;
  if (result.is_out_of_time) return out_of_time;
  return result.passed() ? 0 : 1;
}

constexpr const char* no_memory = "calor: there is too little memory: take fewer points, or more machines";

/// While MPI and PETSc start. Where they cannot they end the process with a code that means something else here.
bool is_starting = false;
void tell_of_failed_start() {
  if (!std::exchange(is_starting, false)) return;
  complain("calor: MPI cannot start: look at its message above, for files, memory and a folder for temporary files");
  _exit(code_for_launcher(machine_lacks));
}

/// MPI without files left says much and ends the process with a code of its own.
void require_open_files() {
  constexpr std::size_t needed = 32;  // of MPI, units and results
  std::vector<int> open_files;
  while (open_files.size() < needed && (open_files.empty() || open_files.back() >= 0))
    open_files.push_back(dup(STDERR_FILENO));
  const bool are_enough = open_files.back() >= 0;
  for (const int file : open_files) close(file);
  if (!are_enough)
    throw MachineLacks(fmt::format("fewer than {} more files may be open at once: see ulimit -n", needed));
}

/// Nor do MPI and PETSc start in a folder that has been deleted.
void require_working_folder() {
  std::error_code gone;
  (void)std::filesystem::current_path(gone);
  if (gone) throw MachineLacks("the folder that it is started in is gone: change to another one");
}

/// Runs a verb under MPI and PETSc; PETSc's own handlers would print stacks over our messages.
int under_petsc(char** argv, const std::function<int(MPI_Comm)>& verb) {
  is_starting = true;
  std::atexit(tell_of_failed_start);
  int no_arguments = 1;  // all words on the command line are calor's own; PETSc reads PETSC_OPTIONS
  {
    const SingleProcess alone;
    PetscCall(PetscInitialize(&no_arguments, &argv, nullptr, nullptr));
  }
  PetscCall(PetscPopSignalHandler());
  is_starting = false;
  petsc::collect_errors();
  int code = 0;
  double patience = 1e9;  // s
  std::string message;
  try {
    code = verb(PETSC_COMM_WORLD);
  } catch (const Error& e) {
    code = static_cast<int>(e.fault()), message = e.what(), patience = 60;
  } catch (const CollectiveMismatch& e) {
    code = static_cast<int>(Fault::numbers), message = e.what();
  } catch (const std::bad_alloc&) {
    code = machine_lacks, message = no_memory, patience = 60;
  } catch (const std::exception& e) {  // on this rank alone
    complain(fmt::format("calor: {}", e.what()));
    MPI_Abort(PETSC_COMM_WORLD, code_for_launcher(static_cast<int>(Fault::numbers)));
  }
  if (!message.empty() && rank_of(PETSC_COMM_WORLD) == 0) complain(message);
  // Errors are everyone's. If this one were not, the other ranks would wait for this one for ever.
  if (!all_arrive(PETSC_COMM_WORLD, patience)) {
    complain(fmt::format("on rank {} alone: {}", rank_of(PETSC_COMM_WORLD), message));
    MPI_Abort(PETSC_COMM_WORLD, code_for_launcher(code));
  }
  code = finish_output(code);
  PetscCall(PetscFinalize());
  return code_for_launcher(code);
}

/// Runs the command on several processes and tells what they could not tell.
int launch_verb(const CommandLine& a, const std::vector<std::string>& words) {
  const int most = std::max(64, 4 * static_cast<int>(std::thread::hardware_concurrency()));
  if (a.ranks > most)
    throw Error(Fault::command, fmt::format("-j {} are too many processes for this machine", a.ranks),
                fmt::format("take at most {}", most));
  // A wrong case is told once, before any rank starts.
  const Case c = Case::read(a.case_file, schema(), a.overrides);
  const Launched ended = launch(a.ranks, words);
  if (!ended.is_told)
    complain(fmt::format("calor: ended by signal {} ({}): {}", ended.code - 128, strsignal(ended.code - 128),
                         left_in(folder_of(a, c))));
  return ended.code;
}

/// The words of the command line without -j N.
std::vector<std::string> without_ranks(int argc, char** argv) {
  std::vector<std::string> words;
  for (int n = 1; n < argc; ++n) {
    const std::string word = argv[n];
    if (word == "-j")
      ++n;
    else if (!word.starts_with("-j"))
      words.push_back(word);
  }
  return words;
}

/// What the first word of the command line says to do.
struct Verbs {
  CLI::App *run, *check, *cloud, *show, *units, *verify, *fresh, *list, *doc, *help;
  std::vector<CLI::App*> of_python;  ///< which the Python package carries out
};

Verbs add_verbs(CLI::App& app, CommandLine& a) {
  Verbs all;
  CLI::App* run = all.run = app.add_subcommand("run", "run a case");
  CLI::App* check = all.check =
      app.add_subcommand("check", "build everything, say sizes, step bound and memory; run nothing");
  CLI::App* cloud = all.cloud =
      app.add_subcommand("cloud", "make the points alone: NAME.vtu to look at, and how good they are");
  for (CLI::App* verb : {run, check, cloud}) {
    verb->add_option("CASE", a.case_file, "case file (TOML)")->required();
    verb->add_option("key=value", a.overrides, "changes to the case, e.g. sph.smoothing=1.3 or variant=NAME");
    verb->add_option("-j", a.ranks, "number of processes")->check(CLI::Range(1, 1 << 20));
    verb->add_option_function<std::string>(
        "--units", [&](const std::string& unit) { a.overrides.push_back("output.temperature=\"" + unit + "\""); },
        "unit of the temperatures it speaks of: K, degC or degF");
  }
  check->add_flag("--numbers", a.numbers, "list the numbers that report.json will have instead, with their units");
  cloud->add_option("-o", a.name, "NAME of the files, a folder before it maybe (default: name of the case)");
  run->add_option("-o", a.folder, "folder for the results (default: results/CASE)");
  run->add_flag("--restart", a.restart, "go on from the newest checkpoint in the folder");
  run->add_option_function<std::string>(
      "--time-limit", [&a](const std::string& text) { a.time_limit = time_of(text); },
      "store the run and end it after this time, e.g. 90s or 3h (code 75)");
  run->add_flag("--quiet", a.quiet, "print errors and failed expectations only");

  CLI::App* show = all.show = app.add_subcommand("show", "print a case with its variant and changes, as a file");
  show->add_option("CASE", a.case_file, "case file (TOML)")->required();
  show->add_option("key=value", a.overrides, "changes to the case, or variant=NAME");
  CLI::App* units = all.units = app.add_subcommand("units", "say how a unit converts to another one");
  units->add_option("UNIT", a.key, "such as degF")->required();
  units->add_option("OTHER", a.name, "such as K")->required();
  CLI::App* verify = all.verify = app.add_subcommand("verify", "run cases and compare with what they expect");
  verify->add_option("CASE|FOLDER", a.paths, "default: cases");
  verify->add_option("--json", a.json, "file for the results as a list");
  CLI::App* fresh = all.fresh = app.add_subcommand("new", "write a commented case to start from");
  fresh->add_option("NAME", a.name, "of the file; without one the starters are listed: plate, rod, disc, ...");
  fresh->add_option("--from", a.from, "an example to copy, with the files that it names");
  CLI::App* list = all.list = app.add_subcommand("examples", "list the cases that come with calor");
  list->add_option("WORD", a.key, "only those that speak of it");
  CLI::App* doc = all.doc = app.add_subcommand("doc", "the manual of case files");
  doc->add_option("WORD", a.key, "a section, a key or whatever it is about: cloud, cloud.rings, radiation, units");
  doc->add_flag("--schema", a.as_schema, "a JSON Schema of case files, for editors");
  CLI::App* help = all.help = app.add_subcommand("help", "what calor can do, or one verb");
  help->add_option("VERB", a.name);

  CLI::App* plot = app.add_subcommand("plot", "draw pictures of a result");
  CLI::App* report = app.add_subcommand("report", "write one page about a result, for a browser");
  CLI::App* certify = app.add_subcommand("certify", "say how sure the numbers of a case are");
  CLI::App* fit = app.add_subcommand("fit", "find unknown numbers of a case from measurements");
  CLI::App* study = app.add_subcommand("study", "run a case with other values of its keys");
  CLI::App* optimise = app.add_subcommand("optimise", "find the numbers of a case for which a result is best");
  all.of_python = {plot, report, certify, fit, study, optimise};
  for (CLI::App* verb : all.of_python) verb->prefix_command()->set_help_flag();  // the Python package reads the rest
  return all;
}

int command(int argc, char** argv) {
  spdlog::set_default_logger(spdlog::stderr_color_mt("calor"));
  spdlog::set_pattern("%v");
  spdlog::set_level(spdlog::level::debug);  // debug: for the log in the result folder only
  const auto terminal = spdlog::default_logger()->sinks().front();
  terminal->set_level(spdlog::level::info);
  spdlog::flush_on(spdlog::level::debug);
  CLI::App app{"calor computes temperatures in solids without a mesh.", "calor"};
  app.set_version_flag("--version", "calor " CALOR_VERSION);
  app.require_subcommand(1);
  app.failure_message(
      [](const CLI::App*, const CLI::Error& e) { return fmt::format("calor: {} (calor help says more)\n", e.what()); });
  CommandLine a;
  a.words = without_ranks(argc, argv);
  const Verbs verbs = add_verbs(app, a);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    app.exit(e);
    return finish_output(0);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return static_cast<int>(Fault::command);
  }

  if (a.quiet || *verbs.verify) terminal->set_level(spdlog::level::err);
  try {
    require_open_files();
    if (*verbs.help && std::ranges::any_of(verbs.of_python, [&](CLI::App* verb) { return verb->get_name() == a.name; }))
      become_python({a.name, "--help"});
    if (*verbs.help) return finish_output(show_help(app, a.name));
    if (*verbs.fresh) return finish_output(new_case(a.name, a.from));
    if (*verbs.list) return finish_output(list_examples(a.key));
    require_working_folder();
    if (std::ranges::any_of(verbs.of_python, [](CLI::App* verb) { return verb->parsed(); }))
      become_python({argv + 1, argv + argc});
    if (*verbs.show) return finish_output(show_case(Case::read(a.case_file, schema(), a.overrides)));
    if (*verbs.units) return finish_output(show_unit(a.key, a.name));
    if (*verbs.doc) {
      say(a.as_schema     ? json_schema(schema())
          : a.key.empty() ? manual(schema())
                          : manual_on(schema(), a.key, stdout_takes_colour()));
      return finish_output(0);
    }
    if (a.ranks > 1) return launch_verb(a, a.words);
  } catch (const Error& e) {
    complain(e.what());
    return static_cast<int>(e.fault());
  }

  return under_petsc(argv, [&](MPI_Comm comm) {
    if (*verbs.check) return check_case(Case::read(a.case_file, schema(), a.overrides), comm, a.numbers);
    if (*verbs.cloud) {
      const Case c = Case::read(a.case_file, schema(), a.overrides);
      return show_cloud(c, a.name.empty() ? c.name() : a.name, comm);
    }
    if (*verbs.verify)
      return calor::verify(a.paths.empty() ? std::vector<std::string>{"cases"} : a.paths, a.json, comm);
    return run_verb(a, comm);
  });
}

/// SuperLU_DIST, which comes with PETSc, has told malloc when it was loaded that freed memory is to stay with the
/// process. Here large arrays go back to the system, so that the peak of memory is that of what is in use at once.
void give_memory_back() {
#ifdef __GLIBC__
  constexpr int large = 1 << 24, most_arrays = 1 << 16;
  mallopt(M_MMAP_MAX, most_arrays), mallopt(M_MMAP_THRESHOLD, large), mallopt(M_TRIM_THRESHOLD, large);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  give_memory_back();
  open_standard_files();
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error as a full disk is
  end_with_launcher();
  try {
    return command(argc, argv);
  } catch (const std::bad_alloc&) {
    complain(no_memory);
  } catch (const std::exception& e) {  // MachineLacks, and what nobody has foreseen
    complain(fmt::format("calor: {}", e.what()));
  }
  return machine_lacks;
}
