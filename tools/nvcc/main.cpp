// SPDX-License-Identifier: Apache-2.0
// nvcc: a front end over clang that knows the common options of NVIDIA's compiler. Build systems
// find it in the toolkit-shaped folder of an installation. A source is compiled to PTX for each
// architecture; the PTX is packed (sunstone_fatbin) and embedded in the host's object.
#include "bin2c.h"
#include "options.h"

#include "api/nvrtc/asm_text.h"
#include "api/nvrtc/compiler.h"
#include "base/error.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <optional>
#include <spawn.h>
#include <sys/wait.h>

extern char** environ;

namespace sunstone::nvcc {

namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

fs::path toolkitRoot() {
    return fs::read_symlink("/proc/self/exe").parent_path().parent_path();
}

std::string shown(const Words& command) {
    std::string text;
    for (const std::string& word : command)
        text += (text.empty() ? "\"" : " \"") + word + "\"";
    return text;
}

// Runs a command; its exit code. Its messages go to a file if there is a name.
int execute(const Words& command, const std::string& messages = "") {
    std::vector<char*> arguments;
    for (const std::string& word : command)
        arguments.push_back(const_cast<char*>(word.c_str())); // posix_spawn does not write
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    if (!messages.empty())
        posix_spawn_file_actions_addopen(&actions, 2, messages.c_str(),
                                         O_WRONLY | O_CREAT | O_TRUNC, 0600);
    pid_t child = 0;
    const int error =
        posix_spawnp(&child, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (error)
        throw std::runtime_error("nvcc fatal   : cannot start " + command[0] + ": " +
                                 std::strerror(error));
    int status = 0;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR)
            return 1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// A step that failed ends the run with its exit code.
struct Failed {
    int code;
};

class Steps {
public:
    explicit Steps(const CommandLine& line) : line_(line) {}

    void run();

private:
    void step(const Words& command);
    void translate(const Words& options, const std::string& source, const std::string& output);
    Words preprocessor() const;
    Words idOf(const std::string& source) const;
    std::string languageOf(const std::string& source) const;
    std::string outputFor(const std::string& source, const char* ending) const;
    void compilePtx(const std::string& source, int architecture, const std::string& output);
    std::string packPtx(const std::string& source);
    Words hostCommand(const std::string& source) const;
    void compileObject(const std::string& source, const std::string& output);
    Words compileAll();
    Words objectsOf(const Words& linked) const;
    void linkDevice(const Words& objects, const std::string& output);
    void link(const Words& objects);
    void compileOnly(Phase phase);
    void showVariables() const;

    const CommandLine& line_;
    nvrtc::TemporaryFolder folder_;
    int files_ = 0;
};

void Steps::step(const Words& command) {
    if (line_.isVerbose || line_.isDry)
        std::fprintf(stderr, "#$ %s\n", shown(command).c_str());
    if (line_.isDry)
        return;
    if (const int code = execute(command))
        throw Failed{code};
}

Words Steps::preprocessor() const {
    const std::string& headers = nvrtc::compiler().headers;
    Words words = {"-D__NVCC__=1",
                   "-D__CUDACC_VER_MAJOR__=13",
                   "-D__CUDACC_VER_MINOR__=0",
                   "-D__CUDACC_VER_BUILD__=0",
                   "-I" + headers,
                   "-include",
                   headers + "/cuda_runtime.h"};
    if (line_.device.relocatable)
        words.push_back("-D__CUDACC_RDC__=1");
    if (line_.perThread)
        words.push_back("-DCUDA_API_PER_THREAD_DEFAULT_STREAM");
    words.insert(words.end(), line_.common.begin(), line_.common.end());
    return words;
}

// Options that name a file's id. With relocatable device code, clang appends the id to the names of
// kernels and variables that only one file knows: static ones, those of unnamed namespaces, kernels
// for local lambdas. Both compilations of a file must have the same id, and two files of a program
// different ones. clang's driver does not pass an id of its own to the host's compilation.
Words Steps::idOf(const std::string& source) const {
    const fs::path here = fs::current_path();
    std::string text = (here / source).string() + '\n' + (here / line_.output).string();
    for (const std::string& word : line_.common)
        text += '\n' + word;
    uint64_t hash = 0xcbf29ce484222325; // FNV-1a
    for (const char c : text)
        hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(hash));
    return {"-fuse-cuid=none", "-Xclang", std::string("-cuid=") + digits};
}

std::string Steps::languageOf(const std::string& source) const {
    if (!line_.language.empty())
        return line_.language == "cu" ? "cuda" : line_.language;
    return source.ends_with(".cu") ? "cuda" : source.ends_with(".c") ? "c" : "c++";
}

std::string Steps::outputFor(const std::string& source, const char* ending) const {
    if (!line_.output.empty())
        return line_.output;
    return fs::path(source).stem().string() + ending;
}

void Steps::compilePtx(const std::string& source, int architecture, const std::string& output) {
    nvrtc::Options device = line_.device;
    device.architecture = architecture;
    device.quiet = true; // the host's compilation has the same warnings
    if (line_.isDry)
        return translate(nvrtc::clangArguments(device), source, output);
    // clang would replace a special file that the output may be.
    const std::string file = folder_.path() + "/" + std::to_string(files_++) + "_device.ptx";
    translate(nvrtc::clangArguments(device), source, file);
    std::ifstream in(file, std::ios::binary);
    std::string ptx(std::istreambuf_iterator<char>(in), {});
    ptx = device.relocatable ? nvrtc::referToStaticVariables(std::move(ptx))
                             : nvrtc::defineVariables(std::move(ptx));
    std::ofstream out(output, std::ios::binary);
    out << ptx;
    if (!out.flush())
        throw std::runtime_error("nvcc fatal   : cannot write " + output);
}

// Device code to PTX. If assembly is in nvcc's dialect, clang gets preprocessed source.
void Steps::translate(const Words& options, const std::string& source, const std::string& output) {
    Words translation = {nvrtc::compiler().path};
    const auto append = [](Words& command, const Words& words) {
        command.insert(command.end(), words.begin(), words.end());
    };
    append(translation, options);
    if (line_.device.relocatable)
        append(translation, idOf(source));
    Words command = translation;
    append(command, preprocessor());
    Words whole = command;
    append(whole, {"-S", "-o", output, source});
    if (line_.isDry)
        return step(whole);
    const std::string messages = folder_.path() + "/messages.txt";
    if (line_.isVerbose)
        std::fprintf(stderr, "#$ %s\n", shown(whole).c_str());
    const int code = execute(whole, messages);
    std::ifstream in(messages);
    const std::string text(std::istreambuf_iterator<char>(in), {});
    if (code == 0 || text.find(nvrtc::kInvalidPercent) == std::string::npos) {
        std::fputs(text.c_str(), stderr);
        if (code)
            throw Failed{code};
        return;
    }
    const std::string preprocessed = folder_.path() + "/preprocessed.cu";
    append(command, {"-E", "-o", preprocessed, source});
    step(command);
    nvrtc::doublePercentsOfFile(preprocessed);
    append(translation, {"-S", "-o", output, preprocessed});
    step(translation);
}

// The fat binary of a source.
std::string Steps::packPtx(const std::string& source) {
    const std::string base = folder_.path() + "/" + std::to_string(files_++);
    Words pack = {(toolkitRoot() / "bin/sunstone_fatbin").string()};
    for (const int architecture : line_.architectures) {
        const std::string ptx = base + "_" + std::to_string(architecture) + ".ptx";
        compilePtx(source, architecture, ptx);
        pack.push_back(ptx);
    }
    pack.push_back(base + ".fatbin");
    step(pack);
    return base + ".fatbin";
}

Words Steps::hostCommand(const std::string& source) const {
    Words command = {nvrtc::compiler().path};
    const auto append = [&](const Words& words) {
        command.insert(command.end(), words.begin(), words.end());
    };
    const std::string language = languageOf(source);
    append({"-x", language});
    if (language != "c")
        append({"-std=" + line_.device.standard});
    if (language == "cuda") {
        append({"--cuda-path=/nonexistent", "--cuda-host-only", "-nocudainc", "-nocudalib",
                "-Wno-c++11-narrowing", "-Xclang", "-fcuda-allow-variadic-functions", "-Xclang",
                "-target-sdk-version=12.0",
                "--cuda-gpu-arch=sm_" + std::to_string(line_.architectures.front())});
        append(preprocessor());
        if (line_.device.relocatable) {
            append({"-fgpu-rdc"});
            append(idOf(source));
        }
        if (line_.perThread)
            append({"-Xclang", "-fgpu-default-stream=per-thread"});
    } else {
        append(line_.common);
        append({"-I" + nvrtc::compiler().headers});
    }
    append(line_.host);
    return command;
}

void Steps::compileObject(const std::string& source, const std::string& output) {
    Words command = hostCommand(source);
    const auto append = [&](const Words& words) {
        command.insert(command.end(), words.begin(), words.end());
    };
    if (languageOf(source) == "cuda")
        append({"-Xclang", "-fcuda-include-gpubinary", "-Xclang", packPtx(source)});
    append(line_.dependency);
    append({"-c", "-o", output, source});
    step(command);
}

Words Steps::compileAll() {
    Words objects;
    for (const std::string& source : line_.sources) {
        objects.push_back(folder_.path() + "/" + std::to_string(files_++) + "_" +
                          fs::path(source).stem().string() + ".o");
        compileObject(source, objects.back());
    }
    return objects;
}

Words Steps::objectsOf(const Words& linked) const {
    Words objects;
    for (const std::string& word : linked)
        if (word[0] != '-' &&
            (word.ends_with(".o") || word.ends_with(".a") || word.ends_with(".obj")))
            objects.push_back(word);
    return objects;
}

void Steps::linkDevice(const Words& objects, const std::string& output) {
    const std::string stub = folder_.path() + "/stub.c";
    Words command = {(toolkitRoot() / "bin/sunstone_link_stub").string(), "--may-be-empty", stub};
    command.insert(command.end(), objects.begin(), objects.end());
    step(command);
    step({nvrtc::compiler().path, "-x", "c", "-fPIC", "-O1", "-c", "-o", output, stub});
}

void Steps::link(const Words& objects) {
    Words all = objects;
    if (line_.device.relocatable) {
        const Words more = objectsOf(line_.linked);
        all.insert(all.end(), more.begin(), more.end());
        const std::string stub = folder_.path() + "/device.o";
        linkDevice(all, stub);
        all.assign(objects.begin(), objects.end());
        all.push_back(stub);
    }
    const std::string libraries = (toolkitRoot() / "lib64").string();
    Words command = {nvrtc::compiler().path};
    const auto append = [&](const Words& words) {
        command.insert(command.end(), words.begin(), words.end());
    };
    append(line_.host);
    if (line_.isShared)
        append({"-shared"});
    append({"-o", line_.output.empty() ? "a.out" : line_.output});
    append(all);
    append(line_.linked);
    append({"-L" + libraries, "-L" + (toolkitRoot() / "device").string()});
    if (line_.runtime == "static")
        append({"-lcudadevrt", "-lcudart_static", "-lrt", "-lpthread", "-ldl"});
    else if (line_.runtime == "shared")
        append({"-lcudadevrt", "-lcudart"});
    step(command);
}

// One output for each source.
void Steps::compileOnly(Phase phase) {
    if (line_.sources.empty())
        throw std::runtime_error(
            "nvcc fatal   : No input files specified; use option --help for more "
            "information");
    if (!line_.output.empty() && line_.sources.size() > 1)
        throw std::runtime_error(
            "nvcc fatal   : A single input file is required for a non-link phase "
            "when an outputfile is specified");
    for (const std::string& source : line_.sources) {
        if (phase == Phase::kCompile) {
            compileObject(source, outputFor(source, ".o"));
        } else if (phase == Phase::kPtx) {
            compilePtx(source, line_.architectures.front(), outputFor(source, ".ptx"));
        } else if (phase == Phase::kFatBinary) {
            const std::string packed = packPtx(source);
            if (!line_.isDry)
                fs::copy_file(packed, outputFor(source, ".fatbin"),
                              fs::copy_options::overwrite_existing);
        } else {
            Words command = hostCommand(source);
            command.insert(command.end(), line_.dependency.begin(), line_.dependency.end());
            if (phase == Phase::kPreprocess)
                command.push_back("-E");
            if (!line_.output.empty())
                command.insert(command.end(), {"-o", line_.output});
            command.push_back(source);
            step(command);
        }
    }
}

// Prints the lines of verbose output that CMake reads.
void Steps::showVariables() const {
    const std::string root = toolkitRoot().string();
    const char* path = std::getenv("PATH");
    std::fprintf(stderr, "#$ TOP=%s\n#$ NVVMIR_LIBRARY_DIR=%s/nvvm/libdevice\n", root.c_str(),
                 root.c_str());
    std::fprintf(stderr, "#$ PATH=%s/bin:%s\n", root.c_str(), path ? path : "");
    std::fprintf(stderr, "#$ INCLUDES=\"-I%s/include\"\n", root.c_str());
    std::fprintf(stderr, "#$ LIBRARIES=  \"-L%s/lib64\" \"-L%s/device\"\n", root.c_str(),
                 root.c_str());
    for (const int architecture : line_.architectures)
        std::fprintf(stderr, "#$ ARCHITECTURE= -arch compute_%d\n", architecture);
}

void Steps::run() {
    if (line_.isVerbose || line_.isDry)
        showVariables();
    if (nvrtc::compiler().path.empty())
        throw std::runtime_error("nvcc fatal   : " + nvrtc::compiler().fault);
    switch (line_.phase) {
    case Phase::kDeviceLink:
        linkDevice(objectsOf(line_.linked), line_.output.empty() ? "a_dlink.o" : line_.output);
        break;
    case Phase::kArchive: {
        Words command = {"ar", "rcs", line_.output.empty() ? "a.a" : line_.output};
        const Words objects = compileAll(), more = objectsOf(line_.linked);
        command.insert(command.end(), objects.begin(), objects.end());
        command.insert(command.end(), more.begin(), more.end());
        step(command);
        break;
    }
    case Phase::kLink:
        if (line_.sources.empty() && objectsOf(line_.linked).empty())
            throw std::runtime_error(
                "nvcc fatal   : No input files specified; use option --help for "
                "more information");
        link(compileAll());
        break;
    default:
        compileOnly(line_.phase);
    }
}

void showHelp() {
    std::puts(
        "Usage: nvcc [options] <inputfile>\n\n"
        "Sunstone's nvcc compiles CUDA C++ with clang: device code becomes PTX, which is embedded "
        "in\n"
        "the host's object. docs/cuda.md of Sunstone lists what differs from NVIDIA's compiler.\n\n"
        "phases:  -c -dc -ptx -fatbin -cubin -E -M -MM -dlink -lib; none: compile and link\n"
        "files:   -o FILE, -x cu|c++|c, --options-file FILE, -MD -MMD -MP -MF -MT -MQ\n"
        "device:  -arch, -gencode, -rdc, -G, -lineinfo, -use_fast_math, -ftz, -fmad, -prec-div,\n"
        "         -prec-sqrt, -default-stream, -extended-lambda, -expt-relaxed-constexpr\n"
        "host:    -I -isystem -include -D -U -std -O -g -w -Xcompiler, "
        "-forward-unknown-to-host-compiler\n"
        "link:    -L -l -shared -cudart static|shared|none, -Xlinker\n"
        "other:   -v -dryrun --version --list-gpu-arch");
}

int start(const Words& words) {
    const CommandLine line = parse(words);
    if (line.showsVersion) {
        // Build systems read the first line and the number after "V".
        std::puts("nvcc: NVIDIA (R) Cuda compiler driver, as Sunstone's front end over clang\n"
                  "Cuda compilation tools, release 13.0, V13.0.0");
        return 0;
    }
    if (line.showsHelp) {
        showHelp();
        return 0;
    }
    if (line.showsArchitectures) {
        for (const int architecture : nvrtc::architectures())
            std::printf("compute_%d\n", architecture);
        return 0;
    }
    Steps(line).run();
    return 0;
}

// ---- the programs that clang calls, if it is the compiler itself ----

// Stands for ptxas, which compiles PTX to machine code; here the PTX stays. Both names of the
// options exist.
int runAssembler(const Words& words) {
    std::string input, output;
    for (size_t i = 0; i < words.size(); ++i) {
        if (words[i] == "--version")
            return std::puts("ptxas of Sunstone: PTX stays PTX, V13.0.0"), 0;
        const bool hasNext = i + 1 < words.size();
        if ((words[i] == "--output-file" || words[i] == "-o") && hasNext)
            output = words[++i];
        else if ((words[i] == "--gpu-name" || words[i] == "-arch" || words[i] == "-maxrregcount") &&
                 hasNext)
            ++i;
        else if (words[i][0] != '-')
            input = words[i];
    }
    if (input.empty() || output.empty())
        throw std::runtime_error("ptxas fatal   : input and output files are needed");
    fs::copy_file(input, output, fs::copy_options::overwrite_existing);
    return 0;
}

// fatbinary --create OUT --image=profile=compute_75,file=X...: for each architecture, one image is
// PTX.
int packImages(const Words& words) {
    std::string output;
    Words virtualFiles, realFiles;
    for (size_t i = 0; i < words.size(); ++i) {
        if (words[i].starts_with("--create=")) {
            output = words[i].substr(9);
        } else if (words[i] == "--create" && i + 1 < words.size()) {
            output = words[++i];
        } else if (words[i].starts_with("--image")) {
            const size_t file = words[i].find(",file=");
            if (file == std::string::npos)
                throw std::runtime_error("fatbinary fatal   : " + words[i] + " names no file");
            const bool isPtx = words[i].find("profile=compute_") != std::string::npos ||
                               words[i].find("kind=ptx") != std::string::npos;
            (isPtx ? virtualFiles : realFiles).push_back(words[i].substr(file + 6));
        }
    }
    const Words& files = virtualFiles.empty() ? realFiles : virtualFiles;
    if (output.empty() || files.empty())
        throw std::runtime_error("fatbinary fatal   : output file and images are needed");
    Words command = {(toolkitRoot() / "bin/sunstone_fatbin").string()};
    command.insert(command.end(), files.begin(), files.end());
    command.push_back(output);
    return execute(command);
}

int runAs(const std::string& name, const Words& words) {
    if (name == "ptxas")
        return runAssembler(words);
    if (name == "fatbinary")
        return packImages(words);
    if (name == "bin2c")
        return runBin2c(words);
    if (name == "nvlink")
        throw std::runtime_error(
            "nvlink fatal   : relocatable device code needs Sunstone's nvcc, or "
            "sunstone_link_stub");
    return start(words);
}

} // namespace

} // namespace sunstone::nvcc

int main(int argc, char** argv) {
    try {
        return sunstone::nvcc::runAs(std::filesystem::path(argv[0]).filename().string(),
                                     {argv + 1, argv + argc});
    } catch (const sunstone::nvcc::Failed& failed) {
        return failed.code;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
