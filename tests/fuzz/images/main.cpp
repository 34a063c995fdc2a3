// SPDX-License-Identifier: Apache-2.0
// Fuzzes the CUDA driver's loading of modules: PTX and fat binaries, changed at random, are loaded
// and all their kernels compiled. For any bytes the call must return a result. An input is
// determined by its number and the files: `fuzz_images --input NUMBER FILES` repeats a failure.
//   fuzz_images [--seconds N] [--start N] [--input N] PTX FILES
// Unreadable memory follows each container.
#include "../last_words.h"
#include "../options.h"
#include "../ptx_changes.h"

#include <cuda.h>

#include <lz4.h>
#include <zstd.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>
#include <string>
#include <vector>

namespace {

using fuzz::Tokens;

std::atomic<unsigned long> gInput{0};

void tellWhere() {
    char text[100];
    const int size =
        std::snprintf(text, sizeof text, "\nfuzz_images: repeat with --input %lu\n", gInput.load());
    if (write(STDERR_FILENO, text, size_t(size)) < 0)
        _exit(3);
}

class Fuzzer {
public:
    Fuzzer(std::vector<Tokens> seeds)
        : seeds_(std::move(seeds)), changes_(seeds_, [this](size_t limit) { return below(limit); }) {
        void* area =
            mmap(nullptr, 2 * kPart, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
        if (area == MAP_FAILED || mprotect(static_cast<char*>(area) + kPart, kPart, PROT_NONE))
            std::abort();
        end_ = static_cast<char*>(area) + kPart;
    }

    void run(unsigned long number) {
        gInput = number;
        alarm(120); // no input takes that long
        random_.seed(number * 7919 + 1);
        const Tokens& seed = seeds_[below(seeds_.size())];
        if (below(3) == 0)
            tryContainer(fuzz::textOf(seed));
        else
            tryText(fuzz::textOf(changes_.changed(seed)));
        alarm(0);
    }

    unsigned long accepted = 0, compiled = 0;

private:
    static constexpr size_t kPart = size_t(1) << 20;

    size_t below(size_t limit) { return random_() % limit; }

    void tryText(const std::string& text) {
        CUmodule module = nullptr;
        if (cuModuleLoadData(&module, text.c_str()) != CUDA_SUCCESS)
            return;
        ++accepted;
        unsigned count = 0;
        cuModuleGetFunctionCount(&count, module);
        std::vector<CUfunction> functions(count);
        cuModuleEnumerateFunctions(functions.data(), count, module);
        for (CUfunction function : functions)
            compiled += cuFuncLoad(function) == CUDA_SUCCESS;
        unload(module);
    }

    static void unload(CUmodule module) {
        if (cuModuleUnload(module) != CUDA_SUCCESS)
            std::abort();
    }

    // A fat binary with one to three entries (layout: tests/cuda/launch_test.cpp).
    std::string container(const std::string& text) {
        std::string entries;
        for (size_t count = 1 + below(3); count > 0; --count) {
            std::string payload = text + '\0';
            const size_t plain = payload.size();
            uint64_t flags = 0;
            const size_t kind = below(3);
            if (kind == 1) {
                std::string packed(ZSTD_compressBound(plain), '\0');
                packed.resize(
                    ZSTD_compress(packed.data(), packed.size(), payload.data(), plain, 1));
                payload = packed;
                flags = 0x8000;
            } else if (kind == 2) {
                std::string packed(size_t(LZ4_compressBound(int(plain))), '\0');
                packed.resize(size_t(LZ4_compress_default(payload.data(), packed.data(), int(plain),
                                                          int(packed.size()))));
                payload = packed;
                flags = 0x2000;
            }
            std::string header(64, '\0');
            const auto put = [&](size_t at, auto value) {
                std::memcpy(&header[at], &value, sizeof value);
            };
            put(0, uint16_t(1 + (below(8) == 0)));
            put(2, uint16_t(0x0101));
            put(4, uint32_t(64));
            put(8, uint64_t((payload.size() + 7) / 8 * 8));
            put(16, uint32_t(kind ? payload.size() : 0));
            put(28, uint32_t(50 + below(50)));
            put(40, flags);
            put(56, uint64_t(kind ? plain : 0));
            payload.resize((payload.size() + 7) / 8 * 8);
            entries += header + payload;
        }
        std::string all(16, '\0');
        const uint32_t magic = 0xBA55ED50;
        const uint16_t version = 1, headerSize = 16;
        const uint64_t size = entries.size();
        std::memcpy(&all[0], &magic, 4);
        std::memcpy(&all[4], &version, 2);
        std::memcpy(&all[6], &headerSize, 2);
        std::memcpy(&all[8], &size, 8);
        return all + entries;
    }

    void tryContainer(const std::string& text) {
        std::string bytes = container(text);
        static constexpr uint64_t kSpecial[] = {
            0,          1,          8,          16,         63,         64,
            0x7fffffff, 0x80000000, 0xffffffff, 0xfffffff0, 1ull << 30, (1ull << 30) + 1,
            1ull << 32, 1ull << 63, ~0ull,      ~0ull - 15, 0x8000,     0x2000,
            0xA000};
        for (size_t edits = below(6); edits > 0; --edits) {
            const size_t width = size_t(1) << below(4);
            size_t at = below(3) ? below(std::min<size_t>(bytes.size(), 96)) : below(bytes.size());
            at -= at % width;
            const uint64_t value = below(2) ? kSpecial[below(std::size(kSpecial))] : random_();
            if (at + width <= bytes.size())
                std::memcpy(&bytes[at], &value, width);
        }
        if (below(4) == 0)
            bytes.resize(1 + below(bytes.size()));
        if (bytes.size() > kPart)
            return;
        char* const image = end_ - bytes.size();
        std::memcpy(image, bytes.data(), bytes.size());
        CUmodule module = nullptr;
        if (cuModuleLoadData(&module, image) == CUDA_SUCCESS) {
            ++accepted;
            unload(module);
        }
        tryLink(image, bytes.size());
    }

    void tryLink(char* image, size_t size) {
        CUlinkState state = nullptr;
        if (cuLinkCreate(0, nullptr, nullptr, &state) != CUDA_SUCCESS)
            std::abort();
        void* linked = nullptr;
        size_t bytes = 0;
        CUmodule module = nullptr;
        cuLinkAddData(state, CUjitInputType(below(7)), image, size, "image", 0, nullptr, nullptr);
        if (cuLinkComplete(state, &linked, &bytes) == CUDA_SUCCESS &&
            cuModuleLoadData(&module, linked) == CUDA_SUCCESS)
            unload(module);
        if (cuLinkDestroy(state) != CUDA_SUCCESS)
            std::abort();
    }

    const std::vector<Tokens> seeds_;
    const fuzz::PtxChanges changes_;
    std::mt19937_64 random_;
    char* end_ = nullptr;
};

} // namespace

int main(int argc, char** argv) {
    const char* const usage = "fuzz_images [--seconds N] [--start N] [--input N] PTX FILES";
    uint64_t seconds = 10, start = 1, input = 0;
    std::vector<std::string> files;
    fuzz::readOptions(argc, argv, usage,
                      {{"--seconds", &seconds}, {"--start", &start}, {"--input", &input}}, &files);
    std::vector<Tokens> seeds;
    for (const std::string& name : files) {
        std::ifstream file(name, std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(file)), {});
        if (!text.empty() && text.size() < 30000)
            seeds.push_back(fuzz::tokensOf(text));
    }
    if (seeds.empty()) {
        std::fprintf(stderr, "no file has PTX to begin with; usage: %s\n", usage);
        return 2;
    }
    fuzz::setLastWords(tellWhere, SIGALRM);
    setenv("OPTIX_CACHE_MAXSIZE", "0", 1);
    setenv("SUNSTONE_LOG", "off", 1);
    CUcontext context = nullptr;
    if (cuInit(0) || cuDevicePrimaryCtxRetain(&context, 0) || cuCtxSetCurrent(context)) {
        std::fprintf(stderr, "no context\n");
        return 1;
    }
    Fuzzer fuzzer(std::move(seeds));
    unsigned long count = 0;
    if (input) {
        fuzzer.run(input);
        ++count;
    } else {
        const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
        for (; std::chrono::steady_clock::now() < end; ++count)
            fuzzer.run(start + count);
    }
    std::printf("%lu inputs from %lu on: %lu accepted, %lu kernels compiled\n", count,
                (unsigned long)(input ? input : start), fuzzer.accepted, fuzzer.compiled);
    return 0;
}
