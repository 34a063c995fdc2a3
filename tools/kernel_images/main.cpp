// SPDX-License-Identifier: Apache-2.0
// A tool of the build: compiles the library's own kernels with ptxas for several compute
// capabilities and writes the archive that engine/gpu/code/kernel_images.h describes.
//   kernel_images OUT PTXAS CAPABILITIES [FILE IDS]...
// Capabilities are separated by commas. IDS is the id of a PTX file's kernels, in which @ stands
// for the kernel's name. The archive also has the kernels of engine/gpu/code/ready_code.h, as parts
// for the driver's linker. With "none" for PTXAS the archive is empty. A capability that ptxas does
// not know is left out.
#include "base/threads/threads.h"
#include "device/cuda/kernel_set.h"
#include "engine/gpu/code/kernel_images.h"
#include "engine/gpu/code/ready_code.h"

#include <zstd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <tuple>
#include <unistd.h>

namespace {

using namespace sunstone;

struct Task {
    std::string id, text;
    unsigned capability = 0;
    std::string options = {};
    std::string code = {}; // empty: ptxas refused the text
};

std::string readFile(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::string bytes{std::istreambuf_iterator<char>(file), {}};
    if (!file && bytes.empty())
        throw std::runtime_error("cannot read " + path);
    return bytes;
}

std::string outputOf(const std::string& command) {
    std::string output;
    std::FILE* pipe = popen(command.c_str(), "r");
    if (!pipe)
        throw std::runtime_error("cannot run " + command);
    char part[4096];
    for (size_t got; (got = std::fread(part, 1, sizeof(part), pipe)) > 0;)
        output.append(part, got);
    pclose(pipe);
    return output;
}

// 1000 * major + 10 * minor of "release 13.0".
uint32_t toolkitOf(const std::string& ptxas) {
    const std::string text = outputOf(ptxas + " --version");
    const size_t at = text.find("release ");
    unsigned major = 0, minor = 0;
    if (at == text.npos || std::sscanf(text.c_str() + at, "release %u.%u", &major, &minor) != 2)
        throw std::runtime_error(ptxas + " --version names no release");
    return 1000 * major + 10 * minor;
}

std::vector<std::string> kernelsIn(const std::string& ptx) {
    constexpr std::string_view kEntry = ".entry ";
    std::vector<std::string> names;
    for (size_t at = ptx.find(kEntry); at != ptx.npos; at = ptx.find(kEntry, at + 1)) {
        const size_t begin = at + kEntry.size();
        names.push_back(ptx.substr(begin, ptx.find_first_of("(\n ", begin) - begin));
    }
    return names;
}

std::string idOf(std::string form, const std::string& name) {
    const size_t at = form.find('@');
    if (at == form.npos)
        throw std::runtime_error("ids without @: " + form);
    return form.replace(at, 1, name);
}

void compile(Task& task, const std::string& ptxas, const std::string& scratch) {
    const std::string ptx = scratch + ".ptx", cubin = scratch + ".cubin";
    std::ofstream(ptx, std::ios::binary) << task.text;
    const std::string command = ptxas + " -arch=sm_" + std::to_string(task.capability) +
                                task.options + " -o '" + cubin + "' '" + ptx + "'";
    if (std::system(command.c_str()) == 0)
        task.code = readFile(cubin);
    unlink(ptx.c_str());
    unlink(cubin.c_str());
}

bool knows(const std::string& ptxas, unsigned capability, const std::string& scratch) {
    const std::string ptx = scratch + ".empty.ptx";
    std::ofstream(ptx) << ".version 6.5\n.target sm_70\n.address_size 64\n";
    const std::string command = ptxas + " -arch=sm_" + std::to_string(capability) +
                                " -o /dev/null '" + ptx + "' >/dev/null 2>&1";
    const bool isKnown = std::system(command.c_str()) == 0;
    unlink(ptx.c_str());
    return isKnown;
}

// Compiles the largest texts first, because they take longest.
void compileAll(std::vector<Task>& tasks, const std::string& ptxas, const std::string& scratch) {
    std::sort(tasks.begin(), tasks.end(),
              [](const Task& a, const Task& b) { return a.text.size() > b.text.size(); });
    std::atomic<size_t> next = 0;
    std::vector<std::thread> threads;
    for (unsigned t = 0; t < std::max(1u, std::thread::hardware_concurrency()); ++t)
        threads.emplace_back([&, t] {
            for (size_t i; (i = next++) < tasks.size();)
                compile(tasks[i], ptxas, scratch + "." + std::to_string(t));
        });
    for (std::thread& thread : threads)
        thread.join();
}

// One text serves all capabilities, as the other kernels' texts do.
void addReadyKernels(std::vector<Task>& tasks, const std::vector<unsigned>& capabilities) {
    constexpr compiler::GpuTarget kOldest = {70, 70, 0};
    const auto kernels = engine::readyKernels(kOldest);
    std::vector<std::string> texts(kernels.size());
    parallelFor(kernels.size(), 1, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            texts[i] = compiler::compileGpuPipeline(kernels[i]).ptx;
    });
    for (size_t i = 0; i < kernels.size(); ++i)
        for (const unsigned capability : capabilities)
            tasks.push_back(
                {engine::readyKernelId(kernels[i]), texts[i], capability,
                 " -c -maxrregcount=" + std::to_string(engine::readyKernelRegisters(kernels[i]))});
}

void append(std::string& to, const void* bytes, size_t count) {
    to.append(static_cast<const char*>(bytes), count);
}

void write(const std::string& path, std::vector<Task>& tasks, uint32_t toolkit) {
    // Sorts tasks, so that all builds produce equal bytes.
    std::sort(tasks.begin(), tasks.end(), [](const Task& a, const Task& b) {
        return std::tie(a.capability, a.id) < std::tie(b.capability, b.id);
    });
    std::string entries;
    engine::KernelArchive header;
    header.toolkit = toolkit;
    for (const Task& task : tasks) {
        if (task.code.empty())
            throw std::runtime_error("ptxas refuses " + task.id);
        std::string packed(ZSTD_compressBound(task.code.size()), '\0');
        packed.resize(ZSTD_compress(packed.data(), packed.size(), task.code.data(),
                                    task.code.size(), ZSTD_maxCLevel()));
        const engine::KernelArchiveEntry entry = {task.capability, uint32_t(task.id.size()),
                                                  uint32_t(task.code.size()),
                                                  uint32_t(packed.size())};
        append(entries, &entry, sizeof(entry));
        entries += task.id + packed;
        ++header.count;
    }
    std::string archive;
    append(archive, &header, sizeof(header));
    std::ofstream file(path, std::ios::binary);
    file << archive << entries;
    if (!file)
        throw std::runtime_error("cannot write " + path);
}

void run(const std::vector<std::string>& words) {
    if (words.size() < 3 || words.size() % 2 == 0)
        throw std::runtime_error("usage: kernel_images OUT PTXAS CAPABILITIES [FILE IDS]...");
    const std::string &out = words[0], &ptxas = words[1];
    std::vector<Task> tasks;
    const bool hasPtxas = ptxas != "none";
    if (hasPtxas) {
        std::vector<unsigned> capabilities;
        std::istringstream list(words[2]);
        for (std::string word; std::getline(list, word, ',');)
            if (knows(ptxas, unsigned(std::stoul(word)), out))
                capabilities.push_back(unsigned(std::stoul(word)));
        for (size_t i = 3; i < words.size(); i += 2) {
            const std::string ptx = readFile(words[i]);
            const device::cuda::KernelTexts texts(ptx);
            for (const std::string& name : kernelsIn(ptx))
                for (const unsigned capability : capabilities)
                    tasks.push_back({idOf(words[i + 1], name), texts.moduleOf(name), capability});
        }
        addReadyKernels(tasks, capabilities);
    }
    compileAll(tasks, ptxas, out);
    write(out, tasks, hasPtxas ? toolkitOf(ptxas) : 0);
}

} // namespace

int main(int argc, char** argv) {
    try {
        run({argv + 1, argv + argc});
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "kernel_images: %s\n", error.what());
        return 1;
    }
}
