// SPDX-License-Identifier: Apache-2.0
// See inputs.h.
#include "inputs.h"

#include "forms/forms.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstdlib>
#include <initializer_list>

namespace conformance {

namespace {

// Vectors that come from the lists of edges; the others are random.
constexpr unsigned kEdgeVectors = kVectors * 11 / 16;

uint32_t bitsOf(float value) {
    return std::bit_cast<uint32_t>(value);
}

std::vector<uint64_t> integers(unsigned bits) {
    std::vector<uint64_t> all = {0,      1,       2,        3,         5,        7,
                                 31,     32,      33,       63,        64,       100,
                                 127,    128,     255,      256,       0x7fff,   0x8000,
                                 0xffff, 0x10000, 0xffffff, 0x1000000, 0x7fffff, 0x800000};
    const uint64_t top = 1ull << (bits - 1);
    for (const uint64_t value : std::initializer_list<uint64_t>{
             top, top - 1, top + 1, ~0ull, ~1ull, ~2ull, ~127ull, ~128ull, ~32767ull, ~32768ull,
             0x123456789abcdef0ull, 0xaaaaaaaaaaaaaaaaull, 0x5555555555555555ull,
             0xff00ff00ff00ff00ull, top >> 1, ~0ull << (bits / 2)})
        all.push_back(value);
    if (bits == 64)
        for (const uint64_t value : std::initializer_list<uint64_t>{
                 0x80000000ull, 0x7fffffffull, 0xffffffffull, 0x100000000ull, 0x8000000080000000ull,
                 0xffffffff00000000ull})
            all.push_back(value);
    return all;
}

std::vector<uint64_t> singles() {
    std::vector<uint64_t> all = {0x00000000, 0x80000000, 0x00000001, 0x80000001, 0x007fffff,
                                 0x807fffff, 0x00400000, 0x00800000, 0x80800000, 0x00800001,
                                 0x7f7fffff, 0xff7fffff, 0x7f800000, 0xff800000, 0x7fc00000,
                                 0xffc01234, 0x7f800001, 0x33800000, 0x33000000, 0x33000001,
                                 0x38800000, 0x387fffff, 0x477fefff, 0x477ff000};
    for (const float value :
         {1.0f,          -1.0f,         1.0000001f,    0.99999994f,    0.5f,
          -0.5f,         0.49999997f,   1.5f,          2.5f,           -2.5f,
          3.5f,          127.5f,        -128.5f,       255.5f,         256.0f,
          -129.0f,       32767.5f,      -32769.0f,     65504.0f,       65535.5f,
          8388609.0f,    2147483520.0f, 2147483648.0f, -2147483648.0f, -2147483904.0f,
          4294967040.0f, 4294967296.0f, 9.223372e18f,  -9.223372e18f,  1.8446744e19f,
          3.1415927f,    -0.7f,         0.1f,          448.0f,         464.0f,
          57344.0f,      61440.0f,      1.00390625f,   1.01171875f,    1.5e-45f,
          3e38f,         -2e-38f})
        all.push_back(bitsOf(value));
    return all;
}

std::vector<uint64_t> doubles() {
    std::vector<uint64_t> all = {0,
                                 1ull << 63,
                                 1,
                                 (1ull << 63) | 1,
                                 0x000fffffffffffffull,
                                 0x0010000000000000ull,
                                 0x8010000000000000ull,
                                 0x7fefffffffffffffull,
                                 0xffefffffffffffffull,
                                 0x7ff0000000000000ull,
                                 0xfff0000000000000ull,
                                 0x7ff8000000000000ull,
                                 0xfff8000000001234ull,
                                 0x7ff0000000000001ull,
                                 0x47efffffe0000000ull,
                                 0x47effffff0000000ull,
                                 0x36a0000000000000ull,
                                 0x3690000000000000ull,
                                 0x3690000000000001ull,
                                 0x380fffffc0000000ull};
    for (const double value : {1.0,
                               -1.0,
                               1.0000000000000002,
                               0.9999999999999999,
                               0.5,
                               -0.5,
                               0.49999999999999994,
                               1.5,
                               2.5,
                               -2.5,
                               127.5,
                               -128.5,
                               255.5,
                               32767.5,
                               65535.5,
                               65519.99,
                               65520.0,
                               2147483647.5,
                               -2147483648.5,
                               4294967295.5,
                               9007199254740993.0,
                               9.2233720368547748e18,
                               9.2233720368547758e18,
                               -9.2233720368547758e18,
                               1.8446744073709552e19,
                               1.8446744073709550e19,
                               3.141592653589793,
                               1e-310,
                               1e300,
                               5.9604644775390625e-08,
                               2.98e-08,
                               6.1e-05,
                               1.0000000596046448,
                               1.0000001788139343})
        all.push_back(std::bit_cast<uint64_t>(value));
    return all;
}

std::vector<uint64_t> halves() {
    return {0x0000, 0x8000, 0x0001, 0x8001, 0x03ff, 0x83ff, 0x0400, 0x8400, 0x0401, 0x3c00,
            0xbc00, 0x3c01, 0x3bff, 0x3800, 0xb800, 0x37ff, 0x3e00, 0x4100, 0xc100, 0x4200,
            0x57f8, 0xd804, 0x5bfc, 0x7bff, 0xfbff, 0x7c00, 0xfc00, 0x7e00, 0xfe12, 0x7c01,
            0x7800, 0x4248, 0x2e66, 0x1000, 0x6800, 0x5640, 0x5f00, 0x5f40, 0x7b00, 0x7b80};
}

std::vector<uint64_t> brains() {
    return {0x0000, 0x8000, 0x0001, 0x8001, 0x007f, 0x807f, 0x0080, 0x8080, 0x0081, 0x3f80, 0xbf80,
            0x3f81, 0x3f7f, 0x3f00, 0xbf00, 0x3eff, 0x3fc0, 0x4020, 0xc020, 0x42ff, 0xc300, 0x437f,
            0x4700, 0x4780, 0x4f00, 0xcf00, 0x4f80, 0x5f00, 0xdf00, 0x5f80, 0x7f7f, 0xff7f, 0x7f80,
            0xff80, 0x7fc0, 0xffc1, 0x7f81, 0x4049, 0x3dcd, 0x3380, 0x3880};
}

std::vector<uint64_t> numbersFrom(int first, int last) {
    std::vector<uint64_t> all;
    for (int i = first; i <= last; ++i)
        all.push_back(uint32_t(i));
    return all;
}

struct InputType {
    std::string name;
    std::vector<uint64_t> edges;
    uint64_t (*random)(uint64_t);
};

uint64_t randomInteger(uint64_t bits) {
    if (bits & 1)
        return bits * 0xd1342543de82ef95ull;
    return uint64_t(int64_t(bits >> 40) - (1 << 23)) >> (bits >> 1 & 15);
}

// Numbers of like size, or any bits.
uint64_t randomSingle(uint64_t bits) {
    const uint32_t any = uint32_t(bits >> 32);
    if (bits & 1)
        return any;
    return (any & 0x807fffff) | uint32_t(117 + (bits >> 1) % 20) << 23;
}
uint64_t randomDouble(uint64_t bits) {
    const uint64_t any = scramble(bits);
    if (bits & 1)
        return any;
    return (any & 0x800fffffffffffffull) | (1013 + (bits >> 1) % 20) << 52;
}
uint64_t randomHalf(uint64_t bits) {
    return bits >> 48;
}
uint64_t randomBrain(uint64_t bits) {
    const auto any = uint16_t(bits >> 48);
    return bits & 1 ? any : uint16_t((any & 0x807f) | (117 + (bits >> 1) % 20) << 7);
}
uint64_t randomAmount(uint64_t bits) {
    return bits & 1 ? bits >> 32 : bits >> 59;
}
uint64_t randomLength(uint64_t bits) {
    return bits >> 58;
}
uint64_t randomArgument(uint64_t bits) {
    const double unit = double(bits >> 11) * 0x1p-53 * 2 - 1;
    const double most[4] = {3.2, 6.2, 40, 300};
    return bitsOf(float(unit * most[bits & 3]));
}

const std::vector<InputType>& types() {
    static const std::vector<InputType> all = [] {
        std::vector<InputType> list = {
            {"i16", integers(16), randomInteger},
            {"i32", integers(32), randomInteger},
            {"i64", integers(64), randomInteger},
            {"f16", halves(), randomHalf},
            {"bf16", brains(), randomBrain},
            {"f32", singles(), randomSingle},
            {"f64", doubles(), randomDouble},
            {"p", {0, 1}, [](uint64_t bits) { return bits >> 63; }},
            {"sh", numbersFrom(0, 66), randomAmount},
            {"len", numbersFrom(0, 66), randomLength},
            {"lane", numbersFrom(0, 40), [](uint64_t bits) { return bits >> 59; }},
            {"nth", numbersFrom(-40, 40),
             [](uint64_t bits) { return uint64_t(uint32_t(int(bits >> 60) - 8)); }},
            {"arg", singles(), randomArgument},
            {"f16x2", {}, nullptr},
            {"bf16x2", {}, nullptr},
        };
        for (const uint64_t amount : std::initializer_list<uint64_t>{
                 127ull, 128ull, 254ull, 255ull, 256ull, 257ull, 0x80000000ull, 0xffffffffull}) {
            list[8].edges.push_back(amount);
            if (amount < 256) // positions and lengths of bit fields end there
                list[9].edges.push_back(amount);
        }
        return list;
    }();
    return all;
}

} // namespace

const std::vector<std::string>& inputTypes() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> list;
        for (const InputType& type : types())
            list.push_back(type.name);
        return list;
    }();
    return names;
}

unsigned inputNumber(const std::string& type) {
    const auto& names = inputTypes();
    const auto found = std::find(names.begin(), names.end(), type);
    if (found == names.end()) {
        std::fprintf(stderr, "no inputs of type \"%s\"\n", type.c_str());
        std::exit(2);
    }
    return unsigned(found - names.begin());
}

uint64_t inputBits(const std::string& type, unsigned position, unsigned index) {
    if (type.ends_with("x2")) {
        const std::string part = type.substr(0, type.size() - 2);
        return inputBits(part, position, index) |
               inputBits(part, position + 3, (index * 5 + 3) % kVectors) << 16;
    }
    const InputType& t = types()[inputNumber(type)];
    const uint64_t random = scramble(scramble(inputNumber(type) * 64 + position) + index);
    uint64_t value = 0;
    if (index >= kEdgeVectors)
        value = t.random(random);
    else if (position == 0) // every edge, several times
        value = t.edges[index % t.edges.size()];
    else // mostly other edges, at times the first operand
        value = random % 16 == 0 ? t.edges[index % t.edges.size()]
                                 : t.edges[(random >> 32) % t.edges.size()];
    const unsigned bits = type == "p" ? 1 : widthOf(type);
    return bits == 64 ? value : value & ((1ull << bits) - 1);
}

size_t inputOffset(const std::string& type, unsigned position) {
    return (size_t(inputNumber(type)) * kOperands + position) * kVectors * 8;
}

std::vector<uint64_t> allInputs() {
    std::vector<uint64_t> all;
    for (const std::string& type : inputTypes())
        for (unsigned position = 0; position < kOperands; ++position)
            for (unsigned index = 0; index < kVectors; ++index)
                all.push_back(inputBits(type, position, index));
    return all;
}

} // namespace conformance
