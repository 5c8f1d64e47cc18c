// The command: a thin layer that reads arguments, owns MPI and PETSc, and turns errors into exit codes.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <thread>

#include "app/doc.hpp"
#include "app/json_schema.hpp"
#include "app/run.hpp"
#include "app/schema.hpp"
#include "app/verbs.hpp"
#include "base/parallel.hpp"
#include "base/petsc.hpp"
#include "base/terminal.hpp"
#include "output/report.hpp"

namespace {

using namespace calor;

struct CommandLine {
  std::string case_file, folder, json, name, from, key;
  std::vector<std::string> overrides, paths;
  int ranks = 1;
  bool quiet = false, as_schema = false;
};

int show_help(CLI::App& app, const std::string& verb) {
  if (verb.empty()) {  // help() of an app is that of the verb it was called with
    fmt::print("{}", app.get_formatter()->make_help(&app, app.get_name(), CLI::AppFormatMode::Normal));
    return 0;
  }
  for (const CLI::App* known : app.get_subcommands({}))
    if (known->get_name() == verb) {
      fmt::print("{}", known->help("calor"));
      return 0;
    }
  throw Error(Fault::command, fmt::format("there is no verb '{}'", verb), "calor help lists them");
}

int run_verb(const CommandLine& a, MPI_Comm comm) {
  const Case c = Case::read(a.case_file, schema(), a.overrides);
  const std::string folder = a.folder.empty() ? "results/" + c.name() : a.folder;
  catch_interrupts();
  const RunResult result = run(c, comm, {.folder = folder, .quiet = a.quiet});
  if (rank_of(comm) == 0) {
    const TemperatureUnit unit = TemperatureUnit::of(c);
    if (!a.quiet) fmt::print("{}\n", fmt::join(summary(result, unit), "\n"));
    for (const Verdict& v : result.verdicts)
      if (!a.quiet || !v.passed) fmt::print("{}\n", line(v, unit, stdout_takes_colour()));
    if (!a.quiet) fmt::print("results      {}\n", folder);
    if (!a.quiet) fmt::print("next         calor report {}\n", folder);
  }
  if (result.interrupted_by) return 128 + result.interrupted_by;
  return result.passed() ? 0 : 1;
}

/// Runs a verb under MPI and PETSc; PETSc's own handlers would print stacks over our messages.
int under_petsc(char** argv, const std::function<int(MPI_Comm)>& verb) {
  int no_arguments = 1;  // all words on the command line are calor's own; PETSc reads PETSC_OPTIONS
  PetscCall(PetscInitialize(&no_arguments, &argv, nullptr, nullptr));
  PetscCall(PetscPopSignalHandler());
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
  } catch (const std::exception& e) {  // such as too little memory, on this rank alone
    fmt::print(stderr, "calor: {}\n", e.what());
    MPI_Abort(PETSC_COMM_WORLD, static_cast<int>(Fault::numbers));
  }
  if (!message.empty() && rank_of(PETSC_COMM_WORLD) == 0) fmt::print(stderr, "{}\n", message);
  // Errors are everyone's. If this one were not, the other ranks would wait for this one for ever.
  if (!all_arrive(PETSC_COMM_WORLD, patience)) {
    fmt::print(stderr, "on rank {} alone: {}\n", rank_of(PETSC_COMM_WORLD), message);
    MPI_Abort(PETSC_COMM_WORLD, code);
  }
  PetscCall(PetscFinalize());
  return code;
}

}  // namespace

int main(int argc, char** argv) {
  end_with_launcher();
  // Alone, without Open MPI's helper process: those of runs that start at once trip over each other's folders.
  setenv("OMPI_MCA_ess_singleton_isolated", "1", 0);
  spdlog::set_default_logger(spdlog::stderr_color_mt("calor"));
  spdlog::set_pattern("%v");
  spdlog::set_level(spdlog::level::debug);  // debug: for the log in the result folder only
  const auto terminal = spdlog::default_logger()->sinks().front();
  terminal->set_level(spdlog::level::info);
  spdlog::flush_on(spdlog::level::debug);
  CLI::App app{"calor computes temperatures in solids without a mesh.", "calor"};
  app.set_version_flag("--version", "calor " CALOR_VERSION);
  app.require_subcommand(1);
  CommandLine a;

  CLI::App* run = app.add_subcommand("run", "run a case");
  CLI::App* check = app.add_subcommand("check", "build everything, say sizes, step bound and memory; run nothing");
  for (CLI::App* verb : {run, check}) {
    verb->add_option("CASE", a.case_file, "case file (TOML)")->required();
    verb->add_option("key=value", a.overrides, "changes to the case, e.g. sph.smoothing=1.3 or variant=NAME");
    verb->add_option("-j", a.ranks, "number of processes")->check(CLI::Range(1, 1 << 20));
    verb->add_option_function<std::string>(
        "--units", [&](const std::string& unit) { a.overrides.push_back("output.temperature=\"" + unit + "\""); },
        "unit of the temperatures it speaks of: K, degC or degF");
  }
  run->add_option("-o", a.folder, "folder for the results (default: results/CASE)");
  run->add_flag("--quiet", a.quiet, "print errors and failed expectations only");

  CLI::App* verify = app.add_subcommand("verify", "run cases and compare with what they expect");
  verify->add_option("CASE|FOLDER", a.paths, "default: cases");
  verify->add_option("--json", a.json, "file for the results as a list");
  CLI::App* fresh = app.add_subcommand("new", "write a commented case to start from");
  fresh->add_option("NAME", a.name, "of the file; without one the starters are listed: plate, rod, disc, ...");
  fresh->add_option("--from", a.from, "an example to copy, with the files that it names");
  CLI::App* list = app.add_subcommand("examples", "list the cases that come with calor");
  list->add_option("WORD", a.key, "only those that speak of it");
  CLI::App* doc = app.add_subcommand("doc", "the manual of case files");
  doc->add_option("WORD", a.key, "a section, a key or whatever it is about: cloud, cloud.rings, radiation, units");
  doc->add_flag("--schema", a.as_schema, "a JSON Schema of case files, for editors");
  CLI::App* help = app.add_subcommand("help", "what calor can do, or one verb");
  help->add_option("VERB", a.name);

  CLI::App* plot = app.add_subcommand("plot", "draw pictures of a result");
  CLI::App* report = app.add_subcommand("report", "write one page about a result, for a browser");
  CLI::App* certify = app.add_subcommand("certify", "say how sure the numbers of a case are");
  CLI::App* fit = app.add_subcommand("fit", "find unknown numbers of a case from measurements");
  CLI::App* study = app.add_subcommand("study", "run a case with other values of its keys");
  const std::vector<CLI::App*> of_python = {plot, report, certify, fit, study};
  for (CLI::App* verb : of_python) verb->prefix_command()->set_help_flag();  // the Python package reads the rest

  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& e) {
    return app.exit(e);
  } catch (const CLI::ParseError& e) {
    app.exit(e);
    return static_cast<int>(Fault::command);
  }

  if (a.quiet || *verify) terminal->set_level(spdlog::level::err);
  try {
    if (*help && std::ranges::any_of(of_python, [&](CLI::App* verb) { return verb->get_name() == a.name; }))
      become_python({a.name, "--help"});
    if (*help) return show_help(app, a.name);
    if (*fresh) return new_case(a.name, a.from);
    if (*list) return list_examples(a.key);
    if (std::ranges::any_of(of_python, [](CLI::App* verb) { return verb->parsed(); }))
      become_python({argv + 1, argv + argc});
    if (*doc) {
      fmt::print("{}", a.as_schema     ? json_schema(schema())
                       : a.key.empty() ? manual(schema())
                                       : manual_on(schema(), a.key, stdout_takes_colour()));
      return 0;
    }
    if (a.ranks > 1) {
      const int most = std::max(64, 4 * static_cast<int>(std::thread::hardware_concurrency()));
      if (a.ranks > most)
        throw Error(Fault::command, fmt::format("-j {} are too many processes for this machine", a.ranks),
                    fmt::format("take at most {}", most));
      Case::read(a.case_file, schema(), a.overrides);  // a wrong case is told once, before any rank starts
      std::vector<std::string> words;
      for (int n = 1; n < argc; ++n) {
        const std::string word = argv[n];
        if (word == "-j")
          ++n;
        else if (!word.starts_with("-j"))
          words.push_back(word);
      }
      return launch(a.ranks, words);
    }
  } catch (const Error& e) {
    fmt::print(stderr, "{}\n", e.what());
    return static_cast<int>(e.fault());
  }

  return under_petsc(argv, [&](MPI_Comm comm) {
    if (*check) return check_case(Case::read(a.case_file, schema(), a.overrides), comm);
    if (*verify) return calor::verify(a.paths.empty() ? std::vector<std::string>{"cases"} : a.paths, a.json, comm);
    return run_verb(a, comm);
  });
}
