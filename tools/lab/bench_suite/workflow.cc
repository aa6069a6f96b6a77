#include "tools/lab/bench_suite/workflow.h"

#include <algorithm>
#include <set>

#include "common/core/version.h"
#include "tools/data/files/shell_word.h"

namespace gw::bench {
namespace {

using tools::ShellWord;

// What a run takes, for schedulers that share memory out: 1.1 GB were the most over the suites.
constexpr char kCellMegabytes[] = "2000";

// A text as a literal of Python. File names may hold any byte but zero.
std::string PythonText(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (c == '\n') {
      out += "\\n";
    } else {
      out += c;
    }
  }
  return out + "\"";
}

std::string Command(const Workflow& w, const std::string& what) {
  std::string out = ShellWord(w.program) + " " + what + " " + ShellWord(w.suite_file) + " --out " +
                    ShellWord(w.out);
  for (const std::string& argument : w.arguments) out += " " + ShellWord(argument);
  return out;
}

std::string CellCommand(const Workflow& w, const Cell& cell) {
  return Command(w, "run-job") + " --input " + ShellWord(cell.input) + " --variant " +
         ShellWord(cell.variant) + " --seed " + std::to_string(cell.seed);
}

std::vector<const SuiteInput*> UsedInputs(const Workflow& w) {
  std::vector<const SuiteInput*> out;
  for (const SuiteInput& input : w.inputs) {
    if (std::any_of(w.cells.begin(), w.cells.end(),
                    [&](const Cell& cell) { return cell.input == input.name; })) {
      out.push_back(&input);
    }
  }
  return out;
}

std::string Tables(const Workflow& w) {
  std::string out = "INPUTS = {\n";
  for (const SuiteInput* input : UsedInputs(w)) {
    out += "    " + PythonText(input->name) + ": [";
    for (const std::string& file : SourcesOf(*input)) out += PythonText(file) + ", ";
    out += "],\n";
  }
  out += "}\nVARIANTS = {\n";
  std::set<std::string> variants;
  for (const Cell& cell : w.cells) {
    if (!variants.insert(cell.variant).second) continue;
    out +=
        "    " + PythonText(VariantFolder(cell.variant)) + ": " + PythonText(cell.variant) + ",\n";
  }
  out += "}\nCELLS = [\n";
  for (const Cell& cell : w.cells) out += "    " + PythonText(CellFolder(cell) + "/done") + ",\n";
  return out + "]\n";
}

std::string Snakefile(const Workflow& w) {
  std::string out = "# Written by gw-bench " + std::string(Version()) +
                    ". One job per run; what is finished is not run again.\n"
                    "#   this machine:  cd " +
                    ShellWord(w.out) +
                    " && snakemake --cores all\n"
                    "#   Slurm:         cd " +
                    ShellWord(w.out) +
                    " && snakemake --profile ./slurm\n"
                    "#   GNU parallel:  cd " +
                    ShellWord(w.out) +
                    " && parallel < inputs.jobs && parallel < cells.jobs && sh table.jobs\n"
                    "# Programs and folders are expected at the same place on every machine.\n"
                    "workdir: " +
                    PythonText(w.out) + "\n\n" + Tables(w);
  out += "BENCH = " + PythonText(ShellWord(w.program)) +
         "\nSUITE = " + PythonText(Command(w, "").substr(ShellWord(w.program).size() + 2)) + "\n";
  out += R"(
localrules: table

rule table:
    input: CELLS
    output: "table.md", "table.csv", "timing.csv", "ranking.svg", "inputs.svg"
    shell: "{BENCH} collect {SUITE} > /dev/null"

rule input:
    input: lambda wildcards: INPUTS[wildcards.name]
    output: touch("inputs/{name}.done")
    shell: "{BENCH} prepare {SUITE} --input {wildcards.name}"

rule cell:
    input: "gw-slam", "inputs/{name}.done"
    output: touch("cells/{name}/{folder}/seed-{seed}/done")
    params: variant=lambda wildcards: VARIANTS[wildcards.folder]
    resources: mem_mb=)" +
         std::string(kCellMegabytes) + R"(
    shell:
        "{BENCH} run-job {SUITE} --input {wildcards.name} --variant {params.variant:q}"
        " --seed {wildcards.seed}"
)";
  return out;
}

// Why srun for each job, and not sbatch: it ends when the job ends, with the job's exit code, also
// when the job is killed, so that no accounting database has to be asked.
constexpr char kSlurmProfile[] =
    R"(# Profile of Snakemake for a Slurm cluster whose machines share the folders.
cluster-sync: "srun --quiet --ntasks=1 --cpus-per-task={threads} --mem={resources.mem_mb} --job-name=gw-bench-{rule}"
default-resources: ["mem_mb=4000"]
jobs: 500
restart-times: 1
keep-going: true
latency-wait: 60
)";

}  // namespace

std::vector<std::pair<std::string, std::string>> RenderWorkflow(const Workflow& workflow) {
  std::string inputs, cells;
  for (const SuiteInput* input : UsedInputs(workflow)) {
    inputs += Command(workflow, "prepare") + " --input " + ShellWord(input->name) + "\n";
  }
  for (const Cell& cell : workflow.cells) cells += CellCommand(workflow, cell) + "\n";
  return {{"Snakefile", Snakefile(workflow)},
          {"slurm/config.yaml", kSlurmProfile},
          {"inputs.jobs", inputs},
          {"cells.jobs", cells},
          {"table.jobs", Command(workflow, "collect") + "\n"}};
}

}  // namespace gw::bench
