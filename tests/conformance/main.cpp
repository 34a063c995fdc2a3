// SPDX-License-Identifier: Apache-2.0
// Conformance vectors of PTX: records them on a device, and replays them on another.
//   conformance record FILE [--like FILE]
//       runs every form on the device that libcuda.so.1 finds and writes the recording; --like
//       leaves out the forms that the driver of that recording refused
//   conformance replay FILE [GAPS [DEVIATIONS]]
//       runs the forms of a recording and compares; GAPS names, one a line, the forms that the
//       device is known to refuse, and DEVIATIONS those whose recording is known to be wrong, with
//       the intended difference
//   conformance record-textures FILE
//   conformance replay-textures FILE [GAPS [DEVIATIONS]]
//       the same with textures and surfaces
//   conformance record-matrices FILE [--whole 1]
//   conformance replay-matrices FILE [GAPS]
//       the same with matrix instructions; --whole keeps results, not only digests of them
//   conformance record-errors FILE
//   conformance check-errors FILE
//       largest errors of the .approx functions, by --samples N arguments of each (errors.h)
//   conformance constants [--seed N] [--forms N]
//       compares forms that have constant operands with the same forms and loaded operands
//       (constants.h); the seed chooses the forms and constants, by default the clock chooses it
//   conformance ptx FOLDER
//       writes the modules as text
//   conformance list
//       prints the forms and how their results compare
// --only TEXT limits each to forms with TEXT in their names.
#include "compare.h"
#include "constants.h"
#include "driver.h"
#include "errors.h"
#include "matrices/matrix_cases.h"
#include "matrices/matrix_run.h"
#include "module_writer.h"
#include "names.h"
#include "recording.h"
#include "textures/texture_run.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <set>

using namespace conformance;

namespace {

std::string only;

template <class Named>
std::vector<std::string> namesOf(const std::vector<Named>& all) {
    std::vector<std::string> names;
    for (const Named& one : all)
        names.push_back(one.name);
    return names;
}

std::vector<size_t> chosen(const std::vector<Form>& forms) {
    std::vector<size_t> numbers;
    for (size_t i = 0; i < forms.size(); ++i)
        if (forms[i].name.find(only) != std::string::npos)
            numbers.push_back(i);
    return numbers;
}

int record(const std::string& file, const std::string& like) {
    const std::vector<Form> forms = allForms();
    checkSelection(namesOf(forms), only);
    std::vector<size_t> numbers = chosen(forms);
    std::set<std::string> refused;
    if (!like.empty()) {
        const Recording known = load(like);
        for (const auto& [name, form] : known.forms)
            if (form.status == Status::kRefused)
                refused.insert(name);
        std::erase_if(numbers, [&](size_t i) { return refused.contains(forms[i].name); });
    }
    Results results = runForms(forms, numbers, 0);
    size_t counts[4] = {};
    for (size_t i = 0; i < forms.size(); ++i) {
        if (refused.contains(forms[i].name))
            results.status[i] = Status::kRefused;
        ++counts[size_t(results.status[i])];
        if (results.status[i] == Status::kRefused || results.status[i] == Status::kCrashed)
            std::printf("%s: %s\n", results.status[i] == Status::kRefused ? "refused" : "CRASHED",
                        forms[i].name.c_str());
    }
    std::printf("%s: %zu forms recorded, %zu refused, %zu crashed, %zu not chosen\n",
                results.device.c_str(), counts[1], counts[2], counts[3], counts[0]);
    save(file, forms, results);
    return counts[3] ? 1 : 0;
}

struct Counts {
    unsigned agreed = 0, refused = 0, different = 0, crashed = 0, known = 0, notThere = 0,
             deviating = 0;
};

void say(const char* what, const Form& form, const std::string& text = "") {
    std::printf("%s: %s\n%s", what, form.name.c_str(), text.c_str());
}

int replay(const std::string& file, const std::string& gapsFile,
           const std::string& deviationsFile) {
    const std::vector<Form> forms = allForms();
    const Recording recording = load(file);
    const std::set<std::string> gaps = readNames(gapsFile);
    const Deviations deviations = readDeviations(deviationsFile);
    checkSelection(namesOf(forms), only, gaps, deviations);
    if (recording.inputs != inputsHash())
        quit(1, "the inputs are not those of the recording: record again");
    Counts report;
    std::vector<size_t> numbers;
    for (const size_t i : chosen(forms)) {
        const auto found = recording.forms.find(forms[i].name);
        if (found == recording.forms.end() || found->second.code != codeHash(forms[i])) {
            say("not in the recording", forms[i]);
            ++report.different;
        } else if (found->second.status == Status::kDone) {
            numbers.push_back(i);
        } else {
            ++report.notThere;
        }
    }
    const Results results = runForms(forms, numbers, 0);
    for (const size_t i : numbers) {
        const Form& form = forms[i];
        const bool gap = isNamed(gaps, form.name);
        if (results.status[i] == Status::kRefused && gap) {
            ++report.known;
        } else if (results.status[i] == Status::kRefused) {
            ++report.refused;
            say("refused", form);
        } else if (results.status[i] != Status::kDone) {
            ++report.crashed;
            say("crashed", form);
        } else if (gap) {
            ++report.different;
            say("named as a gap, but it runs", form);
        } else {
            const Difference difference =
                compare(form, recording.forms.at(form.name).results, results.results[i]);
            if (const auto listed = deviations.find(form.name); listed != deviations.end()) {
                const Deviation seen = {difference.vectors, difference.digest};
                ++(seen == listed->second ? report.deviating : report.different);
                if (!(seen == listed->second))
                    say("not the deviation of the list", form,
                        "  here: " + lineOf(form.name, seen) + "\n" + difference.text);
                continue;
            }
            ++(difference.vectors ? report.different : report.agreed);
            if (difference.vectors)
                say("differs", form,
                    "  here: " + lineOf(form.name, {difference.vectors, difference.digest}) + "\n" +
                        difference.text);
        }
    }
    std::printf(
        "recorded on %s, replayed on %s: %u forms agree, %u differ, %u refused, %u crashed; "
        "%u known gaps, %u where the recording is known to be wrong, %u not recorded (the "
        "recorder's driver refused them)\n",
        recording.device.c_str(), results.device.c_str(), report.agreed, report.different,
        report.refused, report.crashed, report.known, report.deviating, report.notThere);
    return report.different + report.refused + report.crashed ? 1 : 0;
}

int recordTextures(const std::string& file) {
    checkSelection(namesOf(allTextureCases()), only);
    const TextureResults results = runTextures(only);
    const std::vector<TextureCase>& cases = allTextureCases();
    size_t counts[4] = {};
    for (size_t i = 0; i < cases.size(); ++i) {
        ++counts[size_t(results.status[i])];
        if (results.status[i] == Status::kRefused || results.status[i] == Status::kCrashed)
            std::printf("%s: %s\n", results.status[i] == Status::kRefused ? "refused" : "CRASHED",
                        cases[i].name.c_str());
    }
    std::printf("%s: %zu texture cases recorded, %zu refused, %zu crashed\n",
                results.device.c_str(), counts[1], counts[2], counts[3]);
    saveTextures(file, results);
    return counts[3] ? 1 : 0;
}

int replayTextures(const std::string& file, const std::string& gapsFile,
                   const std::string& deviationsFile) {
    const std::set<std::string> gaps = readNames(gapsFile);
    const Deviations deviations = readDeviations(deviationsFile);
    checkSelection(namesOf(allTextureCases()), only, gaps, deviations);
    return compareTextures(file, runTextures(only), gaps, deviations, only);
}

int writePtx(const std::string& folder) {
    const std::vector<Form> forms = allForms();
    unsigned count = 0;
    for (const auto& numbers : splitForms(forms, chosen(forms)))
        std::ofstream(folder + "/" + std::to_string(count++) + ".ptx")
            << writeModule(forms, numbers).ptx;
    std::set<std::string> kernels;
    for (const TextureCase& test : allTextureCases())
        kernels.insert(textureKernel(test));
    for (const MatrixCase& test : allMatrixCases())
        kernels.insert(matrixKernel(test));
    for (const std::string& kernel : kernels)
        std::ofstream(folder + "/" + std::to_string(count++) + ".ptx") << kernel;
    return 0;
}

int list() {
    const char* const kRules[] = {"exact",    "exact or NaN", "ulp",
                                  "absolute", "relative",     "relative from 1"};
    const std::vector<Form> forms = allForms();
    for (const size_t i : chosen(forms)) {
        const Rule& rule = forms[i].outputs[0].rule;
        std::printf("%s: %s", forms[i].name.c_str(), kRules[rule.kind]);
        if (rule.bound != 0)
            std::printf(" %g", rule.bound);
        if (rule.limited >= 0)
            std::printf(" for |a%d| <= %g", rule.limited, rule.limit);
        std::printf("\n");
    }
    return 0;
}

} // namespace

int main(int argc, char** argv) {
    std::vector<std::string> words(argv + 1, argv + argc);
    std::string like, whole, samples = "1048576", seed, count = "120";
    const auto option = [&](const std::string& name, std::string& value) {
        for (size_t i = 0; i + 1 < words.size(); ++i)
            if (words[i] == name) {
                value = words[i + 1];
                words.erase(words.begin() + std::ptrdiff_t(i),
                            words.begin() + std::ptrdiff_t(i) + 2);
                return;
            }
    };
    option("--only", only);
    option("--like", like);
    option("--samples", samples);
    option("--whole", whole);
    option("--seed", seed);
    option("--forms", count);
    const std::string verb = words.empty() ? "" : words[0];
    if (verb == "record" && words.size() == 2)
        return record(words[1], like);
    if (verb == "replay" && words.size() >= 2 && words.size() <= 4) {
        words.resize(4);
        return replay(words[1], words[2], words[3]);
    }
    if (verb == "record-textures" && words.size() == 2)
        return recordTextures(words[1]);
    if (verb == "replay-textures" && words.size() >= 2 && words.size() <= 4) {
        words.resize(4);
        return replayTextures(words[1], words[2], words[3]);
    }
    if (verb.ends_with("-matrices"))
        checkSelection(namesOf(allMatrixCases()), only,
                       readNames(words.size() == 3 ? words[2] : ""));
    if (verb == "record-matrices" && words.size() == 2)
        return recordMatrices(words[1], only, !whole.empty());
    if (verb == "replay-matrices" && (words.size() == 2 || words.size() == 3)) {
        words.resize(3);
        return replayMatrices(words[1], readNames(words[2]), only);
    }
    if ((verb == "record-errors" || verb == "check-errors") && words.size() == 2) {
        const auto count =
            unsigned(std::min(std::strtoul(samples.c_str(), nullptr, 10), 1ul << 31));
        if (count == 0)
            quit(2, "--samples is no number above 0");
        return verb == "record-errors" ? recordErrors(words[1], count, only)
                                       : checkErrors(words[1], count, only);
    }
    if (verb == "constants" && words.size() == 1) {
        const auto clock = std::chrono::system_clock::now().time_since_epoch();
        const uint64_t number = seed.empty() ? uint64_t(clock / std::chrono::seconds(1))
                                             : std::strtoull(seed.c_str(), nullptr, 10);
        checkSelection(namesOf(allForms()), only);
        return checkConstants(number, std::strtoull(count.c_str(), nullptr, 10), only) ? 0 : 1;
    }
    if (verb == "ptx" && words.size() == 2)
        return writePtx(words[1]);
    if (verb == "list" && words.size() == 1)
        return list();
    std::fprintf(stderr,
                 "usage: conformance record FILE [--like FILE] | replay FILE [GAPS [DEVIATIONS]] | "
                 "record-textures FILE | replay-textures FILE [GAPS [DEVIATIONS]] | "
                 "record-matrices FILE [--whole 1] | replay-matrices FILE [GAPS] | "
                 "record-errors FILE | check-errors FILE [--samples N] | "
                 "constants [--seed N] [--forms N] | ptx FOLDER | list   "
                 "[--only TEXT]\n");
    return 2;
}
