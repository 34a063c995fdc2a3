// SPDX-License-Identifier: Apache-2.0
// See program.h. Each name expression becomes a variable, appended to the source and initialised
// with the expression's address, so the PTX has the lowered name on the variable's line. That line
// is then removed from the PTX.
#include "api/nvrtc/program.h"

#include "api/nvrtc/asm_text.h"
#include "api/nvrtc/compiler.h"
#include "base/error.h"
#include "base/log.h"

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace sunstone::nvrtc {

namespace {

namespace fs = std::filesystem;

constexpr char kVariable[] = "__sunstone_name_";

// A text as part of a line directive.
std::string quoted(const std::string& text) {
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result += '\\';
        result += (c == '\n' || c == '\r') ? ' ' : c;
    }
    return result + "\"";
}

std::string oneLine(std::string text) {
    std::replace(text.begin(), text.end(), '\n', ' ');
    std::replace(text.begin(), text.end(), '\r', ' ');
    return text;
}

void writeFile(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream out(path, std::ios::binary);
    out << text;
    if (!out.flush())
        fail(Code::kFileError, "cannot write ", path.string());
}

// The number of folders that a relative name leads above its start.
int climbOf(const fs::path& name) {
    int depth = 0, least = 0;
    for (const fs::path& part : name) {
        depth += part == ".." ? -1 : part == "." ? 0 : 1;
        least = std::min(least, depth);
    }
    return -least;
}

// The folder of a program's files: names that lead upwards must stay inside the temporary folder.
class Tree {
public:
    Tree(const std::string& root, const std::vector<Header>& headers) : root_(root), folder_(root) {
        folder_ /= "files";
        int climb = 0;
        for (const Header& header : headers)
            climb = std::max(climb, fs::path(header.name).is_absolute() ? 0 : climbOf(header.name));
        for (; climb > 0; --climb)
            folder_ /= "f";
    }
    const fs::path& folder() const { return folder_; }
    fs::path source() const { return folder_ / "program.cu"; }

    void write(const Header& header) {
        const fs::path name = header.name;
        const std::string text = "#line 1 " + quoted(header.name) + "\n" + header.text;
        if (!name.is_absolute()) {
            writeFile((folder_ / name).lexically_normal(), text);
            return;
        }
        // An overlay of clang's file system has absolute names.
        const fs::path file = root_ / ("absolute" + std::to_string(absolute_++));
        writeFile(file, text);
        overlay_ += (overlay_.empty() ? "" : ",") + std::string("{\"type\":\"file\",\"name\":") +
                    quoted(header.name) + ",\"external-contents\":" + quoted(file.string()) + "}";
    }
    // clang's arguments for the headers.
    std::vector<std::string> arguments() const {
        std::vector<std::string> list = {"-I" + folder_.string()};
        if (!overlay_.empty()) {
            const fs::path file = root_ / "overlay.json";
            writeFile(file,
                      "{\"version\":0,\"use-external-names\":false,\"roots\":[" + overlay_ + "]}");
            list.insert(list.end(), {"-ivfsoverlay", file.string()});
        }
        return list;
    }

private:
    fs::path root_, folder_;
    std::string overlay_;
    int absolute_ = 0;
};

std::string sourceText(const std::string& source, const std::string& name,
                       const std::vector<std::string>& expressions, bool defaultDevice) {
    std::string text;
    if (defaultDevice)
        text += "#pragma clang force_cuda_host_device begin\n";
    text += "#line 1 " + quoted(name) + "\n" + source + "\n";
    if (defaultDevice)
        text += "#pragma clang force_cuda_host_device end\n";
    // The expression has a line of its own, which errors show.
    for (size_t i = 0; i < expressions.size(); ++i)
        text += "extern \"C\" __device__ __attribute__((used)) const volatile void* const " +
                (kVariable + std::to_string(i)) + " = (const volatile void*)(\n#line " +
                std::to_string(i + 1) + " \"name expressions\"\n" + oneLine(expressions[i]) +
                "\n);\n";
    return text;
}

// The message for a missing header in the toolkit's words: programs read the header's name in the
// log and compile again with its text.
void nameMissingHeader(std::string& text) {
    const std::string before = ": fatal error: '", after = "' file not found";
    const size_t at = text.find(before), end = text.find(after, at);
    if (at == std::string::npos || end == std::string::npos || text.find('\n', at) < end)
        return;
    text.replace(end, after.size(), "\"");
    text.replace(at, before.size(), ": catastrophic error: cannot open source file \"");
}

// The log in the form of NVRTC, without paths of temporary files.
std::string shownLog(std::string text, const std::string& folder, const std::string& name) {
    for (size_t at; (at = text.find(folder + "/")) != std::string::npos;)
        text.erase(at, folder.size() + 1);
    const std::string summary = " generated when compiling for ";
    if (const size_t at = text.find(summary); at != std::string::npos)
        text.replace(at, text.find('\n', at) - at, " in the compilation of " + quoted(name) + ".");
    nameMissingHeader(text);
    return text;
}

} // namespace

nvrtcResult Program::addName(const std::string& expression) {
    std::lock_guard lock(mutex_);
    if (isCompiled_)
        return NVRTC_ERROR_NO_NAME_EXPRESSIONS_AFTER_COMPILATION;
    expressions_.push_back(expression);
    return NVRTC_SUCCESS;
}

nvrtcResult Program::loweredName(const std::string& expression, const char** name) {
    std::lock_guard lock(mutex_);
    if (!isCompiled_)
        return NVRTC_ERROR_NO_LOWERED_NAMES_BEFORE_COMPILATION;
    const auto found = lowered_.find(expression);
    if (found == lowered_.end())
        return NVRTC_ERROR_NAME_EXPRESSION_NOT_VALID;
    *name = found->second.c_str();
    return NVRTC_SUCCESS;
}

std::string Program::log() {
    std::lock_guard lock(mutex_);
    return log_;
}
std::string Program::ptx() {
    std::lock_guard lock(mutex_);
    return ptx_;
}
std::string Program::image() {
    std::lock_guard lock(mutex_);
    return image_;
}

nvrtcResult Program::compile(const std::vector<std::string>& words, int defaultArchitecture) {
    std::lock_guard lock(mutex_);
    const Options options = parseOptions(words, defaultArchitecture);
    log_.clear();
    ptx_.clear();
    image_.clear();
    for (const std::string& line : options.remarks)
        log_ += line + "\n";
    for (const std::string& line : options.errors)
        log_ += line + "\n";
    if (!options.errors.empty())
        return NVRTC_ERROR_INVALID_OPTION;
    if (compiler().path.empty()) {
        log_ += "nvrtc: error: " + compiler().fault + "\n";
        sunstone::logOnce(LogLevel::kFatal, "nvrtc", compiler().fault);
        return NVRTC_ERROR_BUILTIN_OPERATION_FAILURE;
    }
    const nvrtcResult result = run(options);
    isCompiled_ |= result == NVRTC_SUCCESS;
    return result;
}

// The compiler's run for a source in the folder of the output.
ChildResult Program::runClang(const Options& options, const std::vector<std::string>& folders,
                              const std::string& source, const std::string& output) const {
    std::vector<std::string> translation = {compiler().path};
    const auto append = [](std::vector<std::string>& command,
                           const std::vector<std::string>& list) {
        command.insert(command.end(), list.begin(), list.end());
    };
    append(translation, clangArguments(options));
    std::vector<std::string> command = translation;
    // Sunstone's CUDA headers precede the folders that the program names.
    const std::string& headers = compiler().headers;
    append(command, predefinedMacros(options));
    append(command, {"-I" + headers, "-include", headers + "/cuda_runtime.h", "-include",
                     headers + "/sunstone/rtc.h"});
    append(command, folders);
    append(command, options.preprocessor);
    if (options.sourceFolder)
        append(command,
               {"-I" + (fs::path(name_).has_parent_path() ? fs::path(name_).parent_path().string()
                                                          : std::string("."))});
    std::vector<std::string> whole = command;
    append(whole, {"-S", "-o", output, source});
    const std::string folder = fs::path(output).parent_path().string();
    const ChildResult child = runChild(whole, folder);
    if (child.output.find(kInvalidPercent) == std::string::npos)
        return child;
    const std::string preprocessed = folder + "/preprocessed.cu";
    append(command, {"-E", "-o", preprocessed, source});
    runChild(command, folder);
    doublePercentsOfFile(preprocessed);
    append(translation, {"-S", "-o", output, preprocessed});
    return runChild(translation, folder);
}

nvrtcResult Program::run(const Options& options) {
    const TemporaryFolder folder;
    Tree tree(folder.path(), headers_);
    for (const Header& header : headers_)
        tree.write(header);
    writeFile(tree.source(), sourceText(source_, name_, expressions_, options.defaultDevice));
    const std::string output = folder.path() + "/program.ptx";
    const ChildResult child = runClang(options, tree.arguments(), tree.source().string(), output);
    log_ += shownLog(child.output, tree.folder().string(), name_);
    if (child.started && child.code > 128)
        log_ += message("nvrtc: error: clang ended with signal ", child.code - 128, "\n");
    std::ifstream in(output, std::ios::binary);
    ptx_.assign(std::istreambuf_iterator<char>(in), {});
    if (!options.relocatable)
        ptx_ = defineVariables(std::move(ptx_));
    // The code is -1 if the application reaps all children; clang writes no PTX when it fails.
    const bool isGood = child.started && (child.code == 0 || child.code == -1) &&
                        (options.syntaxOnly || !ptx_.empty());
    if (!isGood || !takeNames()) {
        ptx_.clear();
        return NVRTC_ERROR_COMPILATION;
    }
    if (options.isReal)
        image_ = ptx_;
    return NVRTC_SUCCESS;
}

// Moves the lowered names from the PTX to the table. A line is
//     .visible .const .align 8 .u64 __sunstone_name_0 = generic(_Z3fooi);
bool Program::takeNames() {
    lowered_.clear();
    for (size_t i = 0; i < expressions_.size() && !ptx_.empty(); ++i) {
        const std::string mark = " " + (kVariable + std::to_string(i)) + " = ";
        const size_t at = ptx_.find(mark);
        const size_t end = at == std::string::npos ? at : ptx_.find(";\n", at);
        if (end == std::string::npos) {
            log_ += "nvrtc: error: \"" + expressions_[i] +
                    "\" is not the address of a kernel or variable\n";
            return false;
        }
        std::string name = ptx_.substr(at + mark.size(), end - at - mark.size());
        if (name.starts_with("generic("))
            name = name.substr(8, name.size() - 9);
        lowered_[expressions_[i]] = name;
        const size_t line = ptx_.rfind('\n', at) + 1;
        ptx_.erase(line, end + 2 - line);
    }
    return true;
}

} // namespace sunstone::nvrtc
