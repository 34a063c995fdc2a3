// SPDX-License-Identifier: Apache-2.0
// See options.h: one table of names, both spellings with one dash or two.
#include "options.h"

#include "base/error.h"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <sstream>
#include <string_view>

namespace sunstone::nvcc {

namespace {

enum class Takes { kNothing, kValue };

using Apply = void (*)(CommandLine&, const std::string&);
struct Rule {
    const char* name;
    const char* shortName;
    Takes takes;
    Apply apply;
};

[[noreturn]] void refuse(const std::string& text) {
    throw std::runtime_error("nvcc fatal   : " + text);
}

std::vector<std::string> splitAt(const std::string& text, char separator) {
    std::vector<std::string> parts;
    std::istringstream in(text);
    for (std::string part; std::getline(in, part, separator);)
        if (!part.empty())
            parts.push_back(part);
    return parts;
}

// The words of a text, which may be quoted.
std::vector<std::string> wordsOf(std::istream& in, std::string_view separators) {
    std::vector<std::string> words;
    std::string word;
    bool isQuoted = false, hasWord = false;
    for (char c; in.get(c);) {
        if (c == '"') {
            isQuoted = !isQuoted;
            hasWord = true;
        } else if (c == '\\' && in.peek() != EOF && in.peek() != '\n') {
            word += char(in.get());
            hasWord = true;
        } else if (!isQuoted && separators.find(c) != separators.npos) {
            if (hasWord)
                words.push_back(word);
            word.clear();
            hasWord = false;
        } else {
            word += c;
            hasWord = true;
        }
    }
    if (hasWord)
        words.push_back(word);
    return words;
}

// The architecture of PTX for "compute_75", "sm_75", "sm_90a".
int architectureOf(const std::string& name) {
    const size_t digits = name.find('_') + 1;
    if (name == "native" || name == "all" || name == "all-major")
        return 75;
    if (!name.starts_with("compute_") && !name.starts_with("sm_") && !name.starts_with("lto_"))
        refuse("Unsupported gpu architecture '" + name + "'");
    const int number = std::atoi(name.c_str() + digits);
    if (number < 20 || number > 129)
        refuse("Unsupported gpu architecture '" + name + "'");
    const std::vector<int>& known = nvrtc::architectures();
    const auto above = std::upper_bound(known.begin(), known.end(), number);
    return above == known.begin() ? known.front() : *(above - 1);
}

// As in NVIDIA's nvcc, the last -arch applies.
void setArchitecture(CommandLine& line, const std::string& name) {
    line.architecture = architectureOf(name);
}

// arch=compute_75,code=[sm_75,compute_75]
void addCode(CommandLine& line, const std::string& value) {
    for (const std::string& part : splitAt(value, ','))
        if (part.starts_with("arch=")) {
            line.architectures.push_back(architectureOf(part.substr(5)));
            return;
        }
    refuse("Option '--generate-code', missing 'arch='");
}

template <Phase phase>
void setPhase(CommandLine& line, const std::string&) {
    line.phase = phase;
}
template <bool CommandLine::* member>
void set(CommandLine& line, const std::string&) {
    line.*member = true;
}
template <bool nvrtc::Options::* member>
void setDevice(CommandLine& line, const std::string&) {
    line.device.*member = true;
}
template <bool nvrtc::Options::* member>
void setTruth(CommandLine& line, const std::string& value) {
    if (value != "true" && value != "false")
        refuse("'" + value + "': expected true or false");
    line.device.*member = value == "true";
}
void ignore(CommandLine&, const std::string&) {}
void refuseFormat(CommandLine&, const std::string&) {
    refuse("Sunstone compiles to PTX; OptiX IR and LTO IR are not supported");
}

void compileRelocatable(CommandLine& line, const std::string&) {
    line.phase = Phase::kCompile;
    line.device.relocatable = true;
}
void setFastMath(CommandLine& line, const std::string&) {
    line.device.flush = line.device.contract = line.device.fastFunctions = true;
    line.device.preciseDivision = line.device.preciseRoots = false;
}
void debugDevice(CommandLine& line, const std::string&) {
    line.device.debug = true;
}
void setStandard(CommandLine& line, const std::string& value) {
    // The headers are C++17; older code is mostly valid in it.
    line.device.standard = value < "c++17" ? "c++17" : value;
}
void setRuntime(CommandLine& line, const std::string& value) {
    if (value != "static" && value != "shared" && value != "none")
        refuse("Value '" + value + "' is not defined for option 'cudart'");
    line.runtime = value;
}
void setStream(CommandLine& line, const std::string& value) {
    line.perThread = value == "per-thread";
}
// As in NVIDIA's nvcc, macros and folders also apply to device code.
void forwardToHost(CommandLine& line, const std::string& value) {
    std::istringstream in(value);
    for (const std::string& word : wordsOf(in, ", \t")) {
        if (word.empty())
            continue;
        const bool isOfBoth =
            word.starts_with("-D") || word.starts_with("-U") || word.starts_with("-I");
        (isOfBoth ? line.common : line.host).push_back(word);
    }
}
void forwardToLinker(CommandLine& line, const std::string& value) {
    for (const std::string& part : splitAt(value, ','))
        line.linked.insert(line.linked.end(), {"-Xlinker", part});
}
void setWarnings(CommandLine& line, const std::string& value) {
    if (value.find("all-warnings") != std::string::npos)
        line.host.push_back("-Werror");
}

template <const char* prefix>
void common(CommandLine& line, const std::string& value) {
    line.common.push_back(prefix + value);
}
template <const char* word>
void commonPair(CommandLine& line, const std::string& value) {
    line.common.insert(line.common.end(), {word, value});
}
template <const char* prefix>
void host(CommandLine& line, const std::string& value) {
    line.host.push_back(prefix + value);
}
template <const char* prefix>
void linker(CommandLine& line, const std::string& value) {
    line.linked.push_back(prefix + value);
}
template <const char* word>
void dependency(CommandLine& line, const std::string& value) {
    line.dependency.push_back(word);
    if (!value.empty())
        line.dependency.push_back(value);
}
template <const char* word>
void listDependencies(CommandLine& line, const std::string&) {
    line.phase = Phase::kDependencies;
    line.dependency.push_back(word);
}
constexpr char kDefine[] = "-D", kUndefine[] = "-U", kFolder[] = "-I", kSystem[] = "-isystem",
               kInclude[] = "-include", kOptimise[] = "-O", kDebug[] = "-g", kQuiet[] = "-w",
               kLibrary[] = "-l", kLibraries[] = "-L", kMD[] = "-MD", kMMD[] = "-MMD",
               kMP[] = "-MP", kMF[] = "-MF", kMT[] = "-MT", kMQ[] = "-MQ", kM[] = "-M",
               kMM[] = "-MM", kProfile[] = "-pg", kNoExceptions[] = "-fno-exceptions",
               kTemplateDepth[] = "-ftemplate-depth=", kNoDeprecated[] = "-Wno-deprecated-declarations",
               kTemplateLimit[] = "-ftemplate-backtrace-limit=";

constexpr auto kNone = Takes::kNothing, kValue = Takes::kValue;
constexpr Rule kRules[] = {
    {"version", "V", kNone, set<&CommandLine::showsVersion>},
    {"help", "h", kNone, set<&CommandLine::showsHelp>},
    {"list-gpu-arch", "arch-ls", kNone, set<&CommandLine::showsArchitectures>},
    {"list-gpu-code", "code-ls", kNone, set<&CommandLine::showsArchitectures>},
    {"verbose", "v", kNone, set<&CommandLine::isVerbose>},
    {"dryrun", "dryrun", kNone, set<&CommandLine::isDry>},
    {"compile", "c", kNone, setPhase<Phase::kCompile>},
    {"device-c", "dc", kNone, compileRelocatable},
    {"device-w", "dw", kNone, setPhase<Phase::kCompile>},
    {"ptx", "ptx", kNone, setPhase<Phase::kPtx>},
    {"cubin", "cubin", kNone, setPhase<Phase::kFatBinary>},
    {"fatbin", "fatbin", kNone, setPhase<Phase::kFatBinary>},
    {"preprocess", "E", kNone, setPhase<Phase::kPreprocess>},
    {"device-link", "dlink", kNone, setPhase<Phase::kDeviceLink>},
    {"lib", "lib", kNone, setPhase<Phase::kArchive>},
    {"link", "link", kNone, setPhase<Phase::kLink>},
    {"optix-ir", "optix-ir", kNone, refuseFormat},
    {"dlink-time-opt", "dlto", kNone, refuseFormat},
    {"generate-dependencies", "M", kNone, listDependencies<kM>},
    {"generate-nonsystem-dependencies", "MM", kNone, listDependencies<kMM>},
    {"generate-dependencies-with-compile", "MD", kNone, dependency<kMD>},
    {"generate-nonsystem-dependencies-with-compile", "MMD", kNone, dependency<kMMD>},
    {"generate-dependency-targets", "MP", kNone, dependency<kMP>},
    {"dependency-output", "MF", kValue, dependency<kMF>},
    {"dependency-target-name", "MT", kValue, dependency<kMT>},
    {"quoted-dependency-target-name", "MQ", kValue, dependency<kMQ>},
    {"output-file", "o", kValue, [](CommandLine& l, const std::string& v) { l.output = v; }},
    {"x", "x", kValue, [](CommandLine& l, const std::string& v) { l.language = v; }},
    {"gpu-architecture", "arch", kValue, setArchitecture},
    {"gpu-code", "code", kValue, ignore},
    {"generate-code", "gencode", kValue, addCode},
    {"relocatable-device-code", "rdc", kValue, setTruth<&nvrtc::Options::relocatable>},
    {"cudart", "cudart", kValue, setRuntime},
    {"cudadevrt", "cudadevrt", kValue, ignore},
    {"compiler-options", "Xcompiler", kValue, forwardToHost},
    {"linker-options", "Xlinker", kValue, forwardToLinker},
    {"archive-options", "Xarchive", kValue, ignore},
    {"ptxas-options", "Xptxas", kValue, ignore},
    {"nvlink-options", "Xnvlink", kValue, ignore},
    {"fatbinary-options", "Xfatbin", kValue, ignore},
    {"cudafe-options", "Xcudafe", kValue, ignore},
    {"compiler-bindir", "ccbin", kValue, ignore},
    {"include-path", "I", kValue, common<kFolder>},
    {"system-include", "isystem", kValue, commonPair<kSystem>},
    {"pre-include", "include", kValue, commonPair<kInclude>},
    {"define-macro", "D", kValue, common<kDefine>},
    {"undefine-macro", "U", kValue, common<kUndefine>},
    {"library", "l", kValue, linker<kLibrary>},
    {"library-path", "L", kValue, linker<kLibraries>},
    {"shared", "shared", kNone, set<&CommandLine::isShared>},
    {"std", "std", kValue, setStandard},
    {"optimize", "O", kValue, host<kOptimise>},
    {"debug", "g", kNone, host<kDebug>},
    {"profile", "pg", kNone, host<kProfile>},
    {"device-debug", "G", kNone, debugDevice},
    {"dopt", "dopt", kValue, ignore},
    {"generate-line-info", "lineinfo", kNone, setDevice<&nvrtc::Options::lineInfo>},
    {"disable-warnings", "w", kNone, host<kQuiet>},
    {"Werror", "Werror", kValue, setWarnings},
    {"use_fast_math", "use_fast_math", kNone, setFastMath},
    {"ftz", "ftz", kValue, setTruth<&nvrtc::Options::flush>},
    {"prec-div", "prec-div", kValue, setTruth<&nvrtc::Options::preciseDivision>},
    {"prec-sqrt", "prec-sqrt", kValue, setTruth<&nvrtc::Options::preciseRoots>},
    {"fmad", "fmad", kValue, setTruth<&nvrtc::Options::contract>},
    {"maxrregcount", "maxrregcount", kValue, ignore},
    {"default-stream", "default-stream", kValue, setStream},
    {"machine", "m", kValue, ignore},
    {"m64", "m64", kNone, ignore},
    {"expt-relaxed-constexpr", "expt-relaxed-constexpr", kNone, ignore},
    {"expt-extended-lambda", "expt-extended-lambda", kNone, ignore},
    {"extended-lambda", "extended-lambda", kNone, ignore},
    {"extra-device-vectorization", "extra-device-vectorization", kNone, ignore},
    {"forward-unknown-to-host-compiler", "forward-unknown-to-host-compiler", kNone, ignore},
    {"forward-unknown-to-host-linker", "forward-unknown-to-host-linker", kNone, ignore},
    {"forward-unknown-opts", "forward-unknown-opts", kNone, ignore},
    {"Wno-deprecated-gpu-targets", "Wno-deprecated-gpu-targets", kNone, ignore},
    {"diag-suppress", "diag-suppress", kValue, ignore},
    {"diag-error", "diag-error", kValue, ignore},
    {"diag-warn", "diag-warn", kValue, ignore},
    {"display-error-number", "err-no", kNone, ignore},
    {"no-display-error-number", "no-err-no", kNone, ignore},
    {"threads", "t", kValue, ignore},
    {"split-compile", "split-compile", kValue, ignore},
    {"keep", "keep", kNone, ignore},
    {"keep-dir", "keep-dir", kValue, ignore},
    {"keep-device-functions", "keep-device-functions", kNone, ignore},
    {"save-temps", "save-temps", kNone, ignore},
    {"objdir-as-tempdir", "objtemp", kNone, ignore},
    {"clean-targets", "clean", kNone, ignore},
    {"resource-usage", "res-usage", kNone, ignore},
    {"source-in-ptx", "src-in-ptx", kNone, ignore},
    {"restrict", "restrict", kNone, ignore},
    {"time", "time", kValue, ignore},
    {"no-compress", "no-compress", kNone, ignore},
    {"compress-mode", "compress-mode", kValue, ignore},
    {"target-directory", "target-dir", kValue, ignore},
    {"ftemplate-depth", "ftemplate-depth", kValue, common<kTemplateDepth>},
    {"ftemplate-backtrace-limit", "ftemplate-backtrace-limit", kValue, common<kTemplateLimit>},
    {"no-exceptions", "noeh", kNone, host<kNoExceptions>},
    {"Wno-deprecated-declarations", "Wno-deprecated-declarations", kNone, host<kNoDeprecated>},
    {"Wreorder", "Wreorder", kNone, ignore},
    {"Wdefault-stream-launch", "Wdefault-stream-launch", kNone, ignore},
    {"Wmissing-launch-bounds", "Wmissing-launch-bounds", kNone, ignore},
    {"Wext-lambda-captures-this", "Wext-lambda-captures-this", kNone, ignore},
    {"allow-unsupported-compiler", "allow-unsupported-compiler", kNone, ignore},
    {"use-local-env", "use-local-env", kNone, ignore},
    {"no-align-double", "no-align-double", kNone, ignore},
    {"no-host-device-initializer-list", "nohdinitlist", kNone, ignore},
    {"no-host-device-move-forward", "nohdmoveforward", kNone, ignore},
    {"extensible-whole-program", "ewp", kNone, ignore},
    {"relocatable-ptx", "reloc-ptx", kNone, ignore},
    {"jobserver", "jobserver", kNone, ignore},
    {"archiver-binary", "arbin", kValue, ignore},
    {"optimization-info", "opt-info", kValue, ignore},
    {"static-global-template-stub", "static-global-template-stub", kValue, ignore},
    {"device-entity-has-hidden-visibility", "device-entity-has-hidden-visibility", kValue, ignore},
    {"device-stack-protector", "device-stack-protector", kValue, ignore},
    {"split-compile-extended", "split-compile-extended", kValue, ignore},
    {"fdevice-time-trace", "fdevice-time-trace", kValue, ignore},
    {"brief-diagnostics", "brief-diag", kValue, ignore},
    {"jump-table-density", "jtd", kValue, ignore},
    {"frandom-seed", "frandom-seed", kValue, ignore},
};

const Rule* find(const std::string& name) {
    for (const Rule& rule : kRules)
        if (name == rule.name || name == rule.shortName)
            return &rule;
    return nullptr;
}

bool endsWithAny(const std::string& text, std::initializer_list<const char*> endings) {
    return std::any_of(endings.begin(), endings.end(),
                       [&](const char* ending) { return text.ends_with(ending); });
}

void addFile(CommandLine& line, const std::string& file) {
    const bool isObject =
        endsWithAny(file, {".o", ".obj", ".a", ".so"}) || file.find(".so.") != std::string::npos;
    if (isObject)
        line.linked.push_back(file);
    else
        line.sources.push_back(file);
}

std::vector<std::string> wordsOfFile(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    if (!in)
        refuse("Could not open options file '" + path + "'");
    return wordsOf(in, " \n\r\t");
}

// Replaces --options-file FILE by the words of the file. `depth` limits the nesting, because a file
// may name itself.
std::vector<std::string> expand(const std::vector<std::string>& words, int depth = 0) {
    if (depth > 8)
        refuse("Options files are nested too deeply");
    std::vector<std::string> result;
    for (size_t i = 0; i < words.size(); ++i) {
        std::string file;
        for (const char* name : {"--options-file", "-optf"}) {
            if (words[i] == name && i + 1 < words.size())
                file = words[++i];
            else if (words[i].starts_with(std::string(name) + "="))
                file = words[i].substr(std::string(name).size() + 1);
        }
        if (file.empty()) {
            result.push_back(words[i]);
            continue;
        }
        for (const std::string& path : splitAt(file, ','))
            for (const std::string& word : expand(wordsOfFile(path), depth + 1))
                result.push_back(word);
    }
    return result;
}

// An option of one letter whose value follows directly: -O3, -Ifolder, -lname.
const Rule* findJoined(const std::string& word, std::string& value) {
    if (word.size() < 3 || std::string("DUIlLOxm").find(word[1]) == std::string::npos)
        return nullptr;
    value = word.substr(word[2] == '=' ? 3 : 2);
    return find(word.substr(1, 1));
}

void applyWord(CommandLine& line, const std::vector<std::string>& words, size_t& i, bool forwards) {
    const std::string& word = words[i];
    if (word.empty() || word[0] != '-' || word == "-") {
        addFile(line, word);
        return;
    }
    const size_t dashes = word.starts_with("--") ? 2 : 1;
    const size_t equals = word.find('=');
    const std::string name =
        word.substr(dashes, equals == std::string::npos ? equals : equals - dashes);
    std::string value = equals == std::string::npos ? "" : word.substr(equals + 1);
    const Rule* rule = find(name);
    bool hasValue = equals != std::string::npos;
    if ((!rule || (rule->takes == Takes::kNothing && hasValue)) && dashes == 1) {
        rule = findJoined(word, value);
        hasValue = rule != nullptr;
    }
    if (!rule) {
        if (!forwards)
            refuse("Unknown option '" + word + "'");
        line.host.push_back(word);
        return;
    }
    if (rule->takes == Takes::kValue && !hasValue) {
        if (i + 1 == words.size())
            refuse("Missing value for option '" + name + "'");
        value = words[++i];
    }
    rule->apply(line, value);
}

void addEnvironment(std::vector<std::string>& words, const char* variable, bool isFirst) {
    if (const char* text = std::getenv(variable)) {
        const std::vector<std::string> more = splitAt(text, ' ');
        words.insert(isFirst ? words.begin() : words.end(), more.begin(), more.end());
    }
}

} // namespace

CommandLine parse(std::vector<std::string> words) {
    addEnvironment(words, "NVCC_PREPEND_FLAGS", true);
    addEnvironment(words, "NVCC_APPEND_FLAGS", false);
    words = expand(words);
    const bool forwards = std::any_of(words.begin(), words.end(), [](const std::string& word) {
        return word.find("-forward-unknown-") != std::string::npos;
    });
    CommandLine line;
    for (size_t i = 0; i < words.size(); ++i)
        applyWord(line, words, i, forwards);
    if (line.architecture)
        line.architectures.push_back(line.architecture);
    if (line.architectures.empty())
        line.architectures.push_back(75);
    std::sort(line.architectures.begin(), line.architectures.end());
    line.architectures.erase(std::unique(line.architectures.begin(), line.architectures.end()),
                             line.architectures.end());
    return line;
}

} // namespace sunstone::nvcc
