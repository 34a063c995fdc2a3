// SPDX-License-Identifier: Apache-2.0
// See matrix_run.h. The file is one zstd frame: lines with the device and, per case, its status,
// the hash of all its inputs, and its name; then the stored results of each.
#include "matrices/matrix_run.h"

#include "case_processes.h"
#include "driver.h"
#include "matrices/matrix_cases.h"
#include "recording.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <map>
#include <sstream>
#include <thread>
#include <unistd.h>

namespace conformance {

namespace {

constexpr size_t kCaseBytes = kProblems * kMatrixResultBytes;
constexpr char kLetters[] = {'?', 'r', '-', 'x'}; // by Status

uint32_t caseHash(const MatrixCase& test) {
    std::string all = matrixKernel(test);
    for (unsigned problem = 0; problem < kProblems; ++problem) {
        const std::vector<uint8_t> content = matrixContent(test, problem);
        all.append(content.begin(), content.end());
    }
    return hashOf(all.data(), all.size());
}

// ---- running ----------------------------------------------------------------------------------

bool runCase(const Driver& driver, const MatrixCase& test, CUdeviceptr in, CUdeviceptr out,
             uint8_t* results) {
    for (unsigned problem = 0; problem < kProblems; ++problem) {
        const std::vector<uint8_t> content = matrixContent(test, problem);
        driver.copyIn(in + problem * kProblemBytes, content.data(), content.size());
    }
    driver.clear(out, kCaseBytes);
    CUmodule module = nullptr;
    if (driver.cuModuleLoadDataEx(&module, matrixKernel(test).c_str(), 0, nullptr, nullptr) !=
        CUDA_SUCCESS)
        return false;
    CUfunction function = nullptr;
    void* parameters[] = {&in, &out};
    const bool launched = driver.cuModuleGetFunction(&function, module, "k") == CUDA_SUCCESS &&
                          driver.cuLaunchKernel(function, kProblems, 1, 1, 32, 1, 1, 0, nullptr,
                                                parameters, nullptr) == CUDA_SUCCESS;
    if (launched &&
        (driver.cuCtxSynchronize() != CUDA_SUCCESS || !driver.copyOut(results, out, kCaseBytes)))
        _exit(3); // the context is lost
    driver.cuModuleUnload(module);
    return launched;
}

struct MatrixResults {
    CaseOutcomes outcomes;
    const uint8_t* bytes = nullptr; // kCaseBytes for each case
};

MatrixResults runMatrices(const std::string& only) {
    const std::vector<MatrixCase>& cases = allMatrixCases();
    std::vector<std::string> names;
    for (const MatrixCase& test : cases)
        names.push_back(test.name);
    auto* bytes = share<uint8_t>(cases.size() * kCaseBytes);
    const auto setup = [&](const Driver& driver) {
        const CUdeviceptr in = driver.allocate(kProblems * kProblemBytes);
        const CUdeviceptr out = driver.allocate(kCaseBytes);
        return [&, in, out](size_t i) {
            return runCase(driver, cases[i], in, out, bytes + i * kCaseBytes);
        };
    };
    const unsigned workers = std::max(1u, std::thread::hardware_concurrency());
    return {runCases(names, only, workers, "matrices", setup), bytes};
}

// ---- recordings -------------------------------------------------------------------------------

struct Recorded {
    char status = '?';
    uint32_t hash = 0;
    uint32_t digests[kProblems] = {};
    std::string whole; // empty unless kept
};

std::map<std::string, Recorded> loadMatrices(const std::string& file, std::string& device) {
    const std::string bytes = loadCompressed(file);
    const CaseHead head = readHead(bytes, file, "matrices");
    device = head.device;
    const bool whole = head.note == " 1";
    std::map<std::string, Recorded> all;
    size_t at = head.end;
    for (const CaseHead::Case& one : head.cases) {
        Recorded* recorded = &all[one.name];
        recorded->status = one.status;
        recorded->hash = one.hash;
        if (one.status != 'r')
            continue;
        if (at + sizeof recorded->digests + (whole ? kCaseBytes : 0) > bytes.size())
            quit(1, file + " ends too early");
        std::memcpy(recorded->digests, bytes.data() + at, sizeof recorded->digests);
        at += sizeof recorded->digests;
        if (whole)
            recorded->whole = bytes.substr(at, kCaseBytes);
        at += whole ? kCaseBytes : 0;
    }
    return all;
}

uint32_t digestOf(const uint8_t* results, unsigned problem) {
    return hashOf(results + problem * kMatrixResultBytes, kMatrixResultBytes);
}

// The problems whose results differ, and some words of known ones.
std::string differences(const Recorded& recorded, const uint8_t* results) {
    constexpr unsigned kShown = 6;
    std::string text;
    unsigned shown = 0;
    for (unsigned problem = 0; problem < kProblems; ++problem) {
        if (recorded.digests[problem] == digestOf(results, problem))
            continue;
        text += " " + std::to_string(problem);
        for (size_t i = 0; i < kMatrixResultBytes && !recorded.whole.empty(); i += 4) {
            uint32_t want = 0, got = 0;
            std::memcpy(&want, recorded.whole.data() + problem * kMatrixResultBytes + i, 4);
            std::memcpy(&got, results + problem * kMatrixResultBytes + i, 4);
            char line[80];
            std::snprintf(line, sizeof line, "\n  lane %zu word %zu: %08x, recorded %08x\n", i / 64,
                          i % 64 / 4, got, want);
            if (want != got && shown++ < kShown)
                text += line;
        }
    }
    return text.empty() ? text : "differs in problems" + text;
}

} // namespace

int recordMatrices(const std::string& file, const std::string& only, bool whole) {
    const MatrixResults results = runMatrices(only);
    const std::vector<MatrixCase>& cases = allMatrixCases();
    std::ostringstream head;
    head << "matrices " << cases.size() << ' ' << whole << '\n' << results.outcomes.device << '\n';
    std::string data;
    size_t counts[4] = {};
    for (size_t i = 0; i < cases.size(); ++i) {
        const Status status = results.outcomes.status[i];
        ++counts[size_t(status)];
        head << kLetters[size_t(status)] << ' ' << caseHash(cases[i]) << ' ' << cases[i].name
             << '\n';
        if (status == Status::kRefused || status == Status::kCrashed)
            std::printf("%s: %s\n", status == Status::kRefused ? "refused" : "CRASHED",
                        cases[i].name.c_str());
        if (status != Status::kDone)
            continue;
        const uint8_t* own = results.bytes + i * kCaseBytes;
        for (unsigned problem = 0; problem < kProblems; ++problem) {
            const uint32_t digest = digestOf(own, problem);
            data.append(reinterpret_cast<const char*>(&digest), sizeof digest);
        }
        if (whole)
            data.append(own, own + kCaseBytes);
    }
    std::printf("%s: %zu matrix cases recorded, %zu refused, %zu crashed\n", results.outcomes.device.c_str(),
                counts[1], counts[2], counts[3]);
    saveCompressed(file, head.str() + data);
    return counts[3] ? 1 : 0;
}

int replayMatrices(const std::string& file, const std::set<std::string>& gaps,
                   const std::string& only) {
    std::string device;
    const std::map<std::string, Recorded> recorded = loadMatrices(file, device);
    const MatrixResults results = runMatrices(only);
    const std::vector<MatrixCase>& cases = allMatrixCases();
    unsigned agreed = 0, different = 0, known = 0, notThere = 0;
    for (size_t i = 0; i < cases.size(); ++i) {
        const MatrixCase& test = cases[i];
        if (test.name.find(only) == std::string::npos)
            continue;
        const auto found = recorded.find(test.name);
        const bool gap = isNamed(gaps, test.name);
        std::string problem;
        if (found == recorded.end() || found->second.hash != caseHash(test)) {
            problem = "not in the recording";
        } else if (found->second.status != 'r') {
            ++notThere;
            continue;
        } else if (results.outcomes.status[i] != Status::kDone) {
            if (gap) {
                ++known;
                continue;
            }
            problem = results.outcomes.status[i] == Status::kRefused ? "refused" : "crashed";
        } else if (gap) {
            problem = "named as a gap, but it runs";
        } else {
            problem = differences(found->second, results.bytes + i * kCaseBytes);
        }
        ++(problem.empty() ? agreed : different);
        if (!problem.empty())
            std::printf("%s: %s\n", test.name.c_str(), problem.c_str());
    }
    std::printf("recorded on %s, replayed on %s: %u matrix cases agree, %u do not; %u known gaps, "
                "%u not recorded (the recorder's driver refused them)\n",
                device.c_str(), results.outcomes.device.c_str(), agreed, different, known, notThere);
    return different ? 1 : 0;
}

} // namespace conformance
