// SPDX-License-Identifier: Apache-2.0
// Fuzzes what the CUDA driver loads: PTX and fat binaries, changed at random, are loaded and all
// their kernels compiled. Whatever the bytes are, the answer is a result. An input is determined by
// its number and the files, so a failure is repeated with `fuzz_images --input NUMBER FILES`.
//   fuzz_images [--seconds N] [--start N] [--input N] PTX FILES
// A container lies before memory that cannot be read.
#include "../last_words.h"

#include <cuda.h>

#include <lz4.h>
#include <zstd.h>

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
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

using Tokens = std::vector<std::string>;

std::atomic<unsigned long> gInput{0};

void tellWhere() {
    char text[100];
    const int size =
        std::snprintf(text, sizeof text, "\nfuzz_images: repeat with --input %lu\n", gInput.load());
    if (write(STDERR_FILENO, text, size_t(size)) < 0)
        _exit(3);
}

bool isWordPart(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '%' || c == '$';
}
bool isSpace(const std::string& token) {
    return std::isspace(static_cast<unsigned char>(token[0]));
}
bool isNumber(const std::string& token) {
    return std::isdigit(static_cast<unsigned char>(token[0]));
}

// Words, modifiers with their point, runs of space, single other characters.
Tokens tokensOf(const std::string& text) {
    Tokens tokens;
    for (size_t begin = 0; begin < text.size();) {
        size_t end = begin + 1;
        const bool isModifier = text[begin] == '.' && end < text.size() && isWordPart(text[end]);
        if (isWordPart(text[begin]) || isModifier)
            end = size_t(std::find_if_not(text.begin() + ptrdiff_t(end), text.end(), isWordPart) -
                         text.begin());
        else if (std::isspace(static_cast<unsigned char>(text[begin])))
            while (end < text.size() && std::isspace(static_cast<unsigned char>(text[end])))
                ++end;
        tokens.push_back(text.substr(begin, end - begin));
        begin = end;
    }
    return tokens;
}

class Fuzzer {
public:
    Fuzzer(std::vector<Tokens> seeds) : seeds_(std::move(seeds)) {
        for (const Tokens& tokens : seeds_)
            for (const std::string& token : tokens)
                if (token[0] == '.' || isWordPart(token[0]))
                    pool_.push_back(token);
        for (const char* rare : {"0", "-1", "64", "4294967296", "0xffffffffffffffff", "0f7F800000",
                                 "0d7FF8000000000000", "%envreg1", "1000000000"})
            pool_.insert(pool_.end(), 20, rare);
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
            tryContainer(textOf(seed));
        else
            tryText(textOf(changed(seed)));
        alarm(0);
    }

    unsigned long accepted = 0, compiled = 0;

private:
    static constexpr size_t kPart = size_t(1) << 20;

    size_t below(size_t limit) { return random_() % limit; }

    static std::string textOf(const Tokens& tokens) {
        std::string text;
        for (const std::string& token : tokens)
            text += token;
        return text;
    }

    Tokens changed(Tokens tokens) {
        for (size_t edits = 1 + below(4); edits > 0; --edits) {
            size_t at = below(tokens.size());
            for (int tries = 0; tries < 50 && isSpace(tokens[at]); ++tries)
                at = below(tokens.size());
            change(tokens, at);
        }
        return tokens;
    }

    void change(Tokens& tokens, size_t at) {
        const auto place = [&](size_t index) { return tokens.begin() + ptrdiff_t(index); };
        std::string& token = tokens[at];
        const std::string other = tokens[below(tokens.size())];
        switch (below(7)) {
        case 0:
        case 1:
        case 2: // another of its kind
            for (int tries = 0; tries < 200; ++tries) {
                const std::string& found = pool_[below(pool_.size())];
                if ((found[0] == '.') == (token[0] == '.') && isNumber(found) == isNumber(token)) {
                    token = found;
                    return;
                }
            }
            return;
        case 3:
            tokens.erase(place(at));
            return;
        case 4:
            tokens.insert(place(at), other);
            return;
        case 5:
            token = other;
            return;
        default:
            break;
        }
        // A statement less, or one more somewhere.
        size_t begin = at, end = at;
        while (begin > 0 && tokens[begin - 1] != ";")
            --begin;
        while (end < tokens.size() && tokens[end] != ";")
            ++end;
        if (end == tokens.size())
            return;
        const Tokens statement(place(begin), place(end + 1));
        if (below(2)) {
            tokens.erase(place(begin), place(end + 1));
            return;
        }
        size_t to = below(tokens.size());
        while (to < tokens.size() && tokens[to] != ";")
            ++to;
        if (to < tokens.size())
            tokens.insert(place(to + 1), statement.begin(), statement.end());
    }

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

    // A fat binary with one to three entries (tests/cuda/launch_test.cpp says what is where).
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
    Tokens pool_;
    std::mt19937_64 random_;
    char* end_ = nullptr;
};

} // namespace

int main(int argc, char** argv) {
    unsigned long seconds = 10, start = 1, input = 0;
    std::vector<Tokens> seeds;
    for (int i = 1; i < argc; ++i) {
        const std::string name = argv[i];
        unsigned long* const option = name == "--seconds" ? &seconds
                                      : name == "--start" ? &start
                                      : name == "--input" ? &input
                                                          : nullptr;
        if (option && i + 1 < argc) {
            *option = std::strtoul(argv[++i], nullptr, 0);
            continue;
        }
        std::ifstream file(name, std::ios::binary);
        const std::string text((std::istreambuf_iterator<char>(file)), {});
        if (!text.empty() && text.size() < 30000)
            seeds.push_back(tokensOf(text));
    }
    if (seeds.empty()) {
        std::fprintf(stderr,
                     "usage: fuzz_images [--seconds N] [--start N] [--input N] PTX FILES\n");
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
                input ? input : start, fuzzer.accepted, fuzzer.compiled);
    return 0;
}
