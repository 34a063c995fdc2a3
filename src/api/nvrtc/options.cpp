// SPDX-License-Identifier: Apache-2.0
// See options.h. One table has the names. Both spellings, with one dash or two, take "=value" or
// the next word.
#include "api/nvrtc/options.h"

#include "base/error.h"

#include <algorithm>
#include <charconv>

namespace sunstone::nvrtc {

namespace {

enum class Takes { kNothing, kTruth, kText };

using Apply = bool (*)(Options&, const std::string&); // false: the value breaks the rule

struct Rule {
    const char* name;
    const char* shortName;
    Takes takes;
    const char* values; // for the error
    Apply apply;
};

template <bool Options::* member>
bool set(Options& options, const std::string&) {
    options.*member = true;
    return true;
}
template <bool Options::* member>
bool setTruth(Options& options, const std::string& value) {
    options.*member = value == "true";
    return true;
}
template <bool Options::* member>
bool clear(Options& options, const std::string&) {
    options.*member = false;
    return true;
}
bool ignore(Options&, const std::string&) {
    return true;
}
bool isNumber(Options&, const std::string& value) {
    return !value.empty() && value.find_first_not_of("0123456789") == std::string::npos;
}

template <const char* prefix>
bool addPreprocessor(Options& options, const std::string& value) {
    options.preprocessor.push_back(prefix + value);
    return true;
}
constexpr char kDefine[] = "-D", kUndefine[] = "-U", kFolder[] = "-I", kInclude[] = "--include=";

bool setArchitecture(Options& options, const std::string& value) {
    const bool isReal = value.starts_with("sm_");
    if (!isReal && !value.starts_with("compute_"))
        return false;
    const char* first = value.data() + value.find('_') + 1;
    const char* last = value.data() + value.size();
    int number = 0;
    const auto [end, error] = std::from_chars(first, last, number);
    const bool hasSuffix = end + 1 == last && (*end == 'a' || *end == 'f');
    // Older releases accepted 20 and 30, which applications of that time use.
    if (error != std::errc() || (end != last && !hasSuffix) || number < 20 || number > 129)
        return false;
    const auto above = std::upper_bound(architectures().begin(), architectures().end(), number);
    const int known = above == architectures().begin() ? *above : *(above - 1);
    if (known != number)
        options.remarks.push_back(message("nvrtc: remark: clang does not know ", value,
                                          "; the PTX is for compute_", known));
    options.architecture = known;
    options.isReal = isReal;
    return true;
}

bool setStandard(Options& options, const std::string& value) {
    for (const char* known : {"c++03", "c++11", "c++14", "c++17", "c++20", "c++23"})
        if (value == known) {
            // The headers are C++17; older code is mostly valid in it.
            options.standard = std::max<std::string>(value == "c++03" ? "" : value, "c++17");
            return true;
        }
    return false;
}

bool setFastMath(Options& options, const std::string&) {
    options.flush = options.contract = options.fastFunctions = true;
    options.preciseDivision = options.preciseRoots = false;
    return true;
}

bool refuseFormat(Options& options, const std::string&) {
    options.errors.push_back("nvrtc: error: Sunstone compiles to PTX; OptiX IR and LTO IR are not "
                             "supported");
    return true;
}

constexpr const char* kTruths = "true or false";
constexpr Rule kRules[] = {
    {"gpu-architecture", "arch", Takes::kText, "compute_XX or sm_XX", setArchitecture},
    {"device-c", "dc", Takes::kNothing, "", set<&Options::relocatable>},
    {"device-w", "dw", Takes::kNothing, "", clear<&Options::relocatable>},
    {"relocatable-device-code", "rdc", Takes::kTruth, kTruths, setTruth<&Options::relocatable>},
    {"extensible-whole-program", "ewp", Takes::kNothing, "", ignore},
    {"device-debug", "G", Takes::kNothing, "", set<&Options::debug>},
    {"generate-line-info", "lineinfo", Takes::kNothing, "", set<&Options::lineInfo>},
    {"dopt", "dopt", Takes::kText, "on", ignore},
    {"ptxas-options", "Xptxas", Takes::kText, "", ignore},
    {"maxrregcount", "maxrregcount", Takes::kText, "a number", isNumber},
    {"ftz", "ftz", Takes::kTruth, kTruths, setTruth<&Options::flush>},
    {"prec-sqrt", "prec-sqrt", Takes::kTruth, kTruths, setTruth<&Options::preciseRoots>},
    {"prec-div", "prec-div", Takes::kTruth, kTruths, setTruth<&Options::preciseDivision>},
    {"fmad", "fmad", Takes::kTruth, kTruths, setTruth<&Options::contract>},
    {"use_fast_math", "use_fast_math", Takes::kNothing, "", setFastMath},
    {"extra-device-vectorization", "extra-device-vectorization", Takes::kNothing, "", ignore},
    {"modify-stack-limit", "modify-stack-limit", Takes::kTruth, kTruths, ignore},
    {"dlink-time-opt", "dlto", Takes::kNothing, "", refuseFormat},
    {"gen-opt-lto", "gen-opt-lto", Takes::kNothing, "", refuseFormat},
    {"optix-ir", "optix-ir", Takes::kNothing, "", refuseFormat},
    {"jump-table-density", "jtd", Takes::kText, "a number", isNumber},
    {"device-stack-protector", "device-stack-protector", Takes::kTruth, kTruths, ignore},
    {"define-macro", "D", Takes::kText, "", addPreprocessor<kDefine>},
    {"undefine-macro", "U", Takes::kText, "", addPreprocessor<kUndefine>},
    {"include-path", "I", Takes::kText, "", addPreprocessor<kFolder>},
    {"pre-include", "include", Takes::kText, "", addPreprocessor<kInclude>},
    {"no-source-include", "no-source-include", Takes::kNothing, "", clear<&Options::sourceFolder>},
    {"std", "std", Takes::kText, "c++03, c++11, c++14, c++17, c++20 or c++23", setStandard},
    {"builtin-move-forward", "builtin-move-forward", Takes::kTruth, kTruths, ignore},
    {"builtin-initializer-list", "builtin-initializer-list", Takes::kTruth, kTruths, ignore},
    {"pch", "pch", Takes::kNothing, "", ignore},
    {"create-pch", "create-pch", Takes::kText, "", ignore},
    {"use-pch", "use-pch", Takes::kText, "", ignore},
    {"pch-dir", "pch-dir", Takes::kText, "", ignore},
    {"pch-verbose", "pch-verbose", Takes::kTruth, kTruths, ignore},
    {"pch-messages", "pch-messages", Takes::kTruth, kTruths, ignore},
    {"instantiate-templates-in-pch", "instantiate-templates-in-pch", Takes::kTruth, kTruths,
     ignore},
    {"disable-warnings", "w", Takes::kNothing, "", set<&Options::quiet>},
    {"Wreorder", "Wreorder", Takes::kNothing, "", ignore},
    {"warning-as-error", "Werror", Takes::kText, "", ignore},
    {"restrict", "restrict", Takes::kNothing, "", ignore},
    {"device-as-default-execution-space", "default-device", Takes::kNothing, "",
     set<&Options::defaultDevice>},
    {"device-int128", "device-int128", Takes::kNothing, "", set<&Options::int128>},
    {"device-float128", "device-float128", Takes::kNothing, "", ignore},
    {"optimization-info", "opt-info", Takes::kText, "", ignore},
    {"display-error-number", "err-no", Takes::kNothing, "", ignore},
    {"no-display-error-number", "no-err-no", Takes::kNothing, "", ignore},
    {"diag-error", "diag-error", Takes::kText, "", ignore},
    {"diag-suppress", "diag-suppress", Takes::kText, "", ignore},
    {"diag-warn", "diag-warn", Takes::kText, "", ignore},
    {"brief-diagnostics", "brief-diag", Takes::kTruth, kTruths, ignore},
    {"time", "time", Takes::kText, "", ignore},
    {"split-compile", "split-compile", Takes::kText, "a number", isNumber},
    {"fdevice-syntax-only", "fdevice-syntax-only", Takes::kNothing, "", set<&Options::syntaxOnly>},
    {"fdevice-time-trace", "fdevice-time-trace", Takes::kText, "", ignore},
    {"frandom-seed", "frandom-seed", Takes::kText, "", ignore},
    {"minimal", "minimal", Takes::kNothing, "", ignore},
    {"no-cache", "no-cache", Takes::kNothing, "", ignore},
    {"version-ident", "version-ident", Takes::kTruth, kTruths, ignore},
};

const Rule* find(const std::string& name) {
    for (const Rule& rule : kRules)
        if (name == rule.name || name == rule.shortName)
            return &rule;
    return nullptr;
}

// A word as name and value: "-Dx" and "-I x" have their values behind one letter.
struct Word {
    std::string name, value;
    bool hasValue = false;
};
Word split(const std::string& text) {
    const size_t dashes = text.starts_with("--") ? 2 : text.starts_with("-") ? 1 : 0;
    if (dashes == 0 || text.size() == dashes)
        return {};
    if (dashes == 1 && std::string("DUI").find(text[1]) != std::string::npos && text.size() > 2) {
        const size_t value = text.find_first_not_of(" \t", text[2] == '=' ? 3 : 2);
        return {text.substr(1, 1), value == std::string::npos ? "" : text.substr(value), true};
    }
    const size_t end = text.find_first_of("= ", dashes);
    if (end == std::string::npos)
        return {text.substr(dashes), "", false};
    return {text.substr(dashes, end - dashes), text.substr(end + 1), true};
}

} // namespace

const std::vector<int>& architectures() {
    static const auto& known =
        *new std::vector<int>{50, 52, 53, 60, 61, 62, 70, 72, 75, 80, 86, 87, 89, 90};
    return known;
}

Options parseOptions(const std::vector<std::string>& words, int defaultArchitecture) {
    Options options;
    options.architecture = defaultArchitecture;
    for (size_t i = 0; i < words.size(); ++i) {
        Word word = split(words[i]);
        const Rule* rule = word.name.empty() ? nullptr : find(word.name);
        if (!rule || (rule->takes == Takes::kNothing && word.hasValue)) {
            options.errors.push_back(
                message("nvrtc: error: unrecognized option ", words[i], " found"));
            continue;
        }
        if (rule->takes != Takes::kNothing && !word.hasValue && i + 1 < words.size())
            word.value = words[++i];
        const bool isTruth = word.value == "true" || word.value == "false";
        if ((rule->takes == Takes::kTruth && !isTruth) || !rule->apply(options, word.value))
            options.errors.push_back(message("nvrtc: error: invalid value \"", word.value,
                                             "\" for --", rule->name, " (-", rule->shortName,
                                             "): it is ", rule->values));
    }
    return options;
}

std::vector<std::string> predefinedMacros(const Options& options) {
    const std::string major = std::to_string(kMajor), minor = std::to_string(kMinor);
    std::vector<std::string> macros = {
        "-D__CUDACC_RTC__=1",
        "-D__NV_BUILTIN_MOVE_FORWARD=1",
        "-D__NVCC_DIAG_PRAGMA_SUPPORT__=1",
        "-D__CUDACC_VER_MAJOR__=" + major,
        "-D__CUDACC_VER_MINOR__=" + minor,
        "-D__CUDACC_VER_BUILD__=0",
        "-D__CUDA_API_VER_MAJOR__=" + major,
        "-D__CUDA_API_VER_MINOR__=" + minor,
        "-DCUDA_VERSION=" + std::to_string(kMajor * 1000 + kMinor * 10),
        "-D__CUDA_ARCH_LIST__=" + std::to_string(options.architecture * 10)};
    if (options.relocatable)
        macros.push_back("-D__CUDACC_RDC__=1");
    if (options.int128)
        macros.push_back("-D__CUDACC_RTC_INT128__=1");
    return macros;
}

std::vector<std::string> clangArguments(const Options& options) {
    const int architecture = options.architecture;
    // Drivers since 470 (CUDA 11.4) read PTX 7.4.
    const char* version = architecture >= 89 ? "+ptx83" : "+ptx74";
    std::vector<std::string> arguments = {
        "-x", "cuda", "--cuda-device-only", "-nocudainc", "-nocudalib", "--cuda-path=/nonexistent",
        "--cuda-gpu-arch=sm_" + std::to_string(architecture), "-Xclang", "-target-feature",
        "-Xclang", version, "-Xclang", "-fcuda-allow-variadic-functions",
        // CUDA code reads memory as other types, passes variables to shuffles that only some lanes
        // have set, omits unused results of functions, and converts colours beyond 255
        // to bytes. nvcc translates all of these as one expects.
        "-fno-strict-aliasing", "-Xclang", "-no-enable-noundef-analysis", "-fno-strict-return",
        "-fno-strict-float-cast-overflow", "-std=" + options.standard, "-fdiagnostics-format=msvc",
        "-fno-show-column", "-fno-color-diagnostics", "-Wno-c++11-narrowing",
        "-Wno-unknown-pragmas", "-Wno-ignored-attributes", "-Wno-unused-command-line-argument"};
    const auto add = [&](bool condition, std::initializer_list<const char*> words) {
        if (condition)
            arguments.insert(arguments.end(), words.begin(), words.end());
    };
    add(options.debug, {"-O0", "-g", "--cuda-noopt-device-debug"});
    add(!options.debug, {"-O3"});
    add(options.lineInfo && !options.debug, {"-gline-directives-only"});
    add(options.relocatable, {"-fgpu-rdc"});
    add(options.flush, {"-fcuda-flush-denormals-to-zero"});
    add(!options.contract, {"-ffp-contract=off"});
    add(!options.preciseDivision, {"-mllvm", "-nvptx-prec-divf32=0"});
    add(!options.preciseRoots, {"-mllvm", "-nvptx-prec-sqrtf32=0"});
    add(options.fastFunctions, {"-fgpu-approx-transcendentals"});
    add(options.quiet, {"-w"});
    add(options.syntaxOnly, {"-fsyntax-only"});
    return arguments;
}

} // namespace sunstone::nvrtc
