// SPDX-License-Identifier: Apache-2.0
// See errors.h. References are computed on the host in a wider format. Subnormal arguments and
// results, and results beyond the range, are left to the vectors of forms_float.cpp.
#include "errors.h"

#include "driver.h"
#include "names.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <limits>
#include <map>
#include <sstream>
#include <thread>
#include <vector>

namespace conformance {

namespace {

using Real = long double;

enum class Measure { kUlp, kRelative, kAbsolute };
constexpr const char* kMeasures[] = {"ulp", "relative", "absolute"};

struct Approximation {
    const char* instruction;
    const char* note; // of the arguments' range
    const char* type; // f32 f64 f16 bf16
    Measure measure;
    double bound;           // of the manual; else by the format
    Real (*function)(Real); // null: division
    bool (*holds)(Real);    // whether the bound is stated for this argument; the divisor's of two
    bool isStated = true;   // by the manual
};

const Real kPi = 3.141592653589793238462643383279502884L;

Real reciprocal(Real x) {
    return 1 / x;
}
Real squareRoot(Real x) {
    return std::sqrt(x);
}
Real reciprocalRoot(Real x) {
    return 1 / std::sqrt(x);
}
Real sine(Real x) {
    return Real(std::sin(double(x)));
}
Real cosine(Real x) {
    return Real(std::cos(double(x)));
}
Real power(Real x) {
    return Real(std::exp2(double(x)));
}
Real logarithm(Real x) {
    return Real(std::log2(double(x)));
}
Real tangent(Real x) {
    return Real(std::tanh(double(x)));
}

bool anywhere(Real) {
    return true;
}
bool ofDivisors(Real x) {
    return std::fabs(x) >= 0x1p-126L && std::fabs(x) <= 0x1p126L;
}
bool near(Real x) {
    return std::fabs(x) <= 2 * kPi;
}
bool far(Real x) {
    return std::fabs(x) <= 100 * kPi;
}
bool aboutOne(Real x) {
    return x > 0.5L && x < 2;
}
bool notAboutOne(Real x) {
    return !aboutOne(x);
}

// Bounds: PTX ISA manual, "Floating Point Instructions" and "Half Precision Floating Point
// Instructions". The flushing f64 functions read only the upper word of their argument and return
// one: each has 20 bits of fraction.
const Approximation kFunctions[] = {
    {"div.approx.f32", "divisor within 2^126", "f32", Measure::kUlp, 2, nullptr, ofDivisors},
    {"div.approx.ftz.f32", "divisor within 2^126", "f32", Measure::kUlp, 2, nullptr, ofDivisors},
    {"div.full.f32", "", "f32", Measure::kUlp, 2, nullptr, anywhere},
    {"div.full.ftz.f32", "", "f32", Measure::kUlp, 2, nullptr, anywhere},
    {"rcp.approx.f32", "", "f32", Measure::kUlp, 1, reciprocal, anywhere},
    {"rcp.approx.ftz.f32", "", "f32", Measure::kUlp, 1, reciprocal, anywhere},
    {"rcp.approx.ftz.f64", "", "f64", Measure::kRelative, 0x1p-20, reciprocal, anywhere, false},
    {"sqrt.approx.f32", "", "f32", Measure::kRelative, 0x1p-23, squareRoot, anywhere},
    {"sqrt.approx.ftz.f32", "", "f32", Measure::kRelative, 0x1p-23, squareRoot, anywhere},
    {"rsqrt.approx.f32", "", "f32", Measure::kRelative, 0x1.125fbep-23, reciprocalRoot, anywhere},
    {"rsqrt.approx.ftz.f32", "", "f32", Measure::kRelative, 0x1.125fbep-23, reciprocalRoot,
     anywhere},
    {"rsqrt.approx.f64", "", "f64", Measure::kRelative, 0x1p-52, reciprocalRoot, anywhere, false},
    {"rsqrt.approx.ftz.f64", "", "f64", Measure::kRelative, 0x1p-20, reciprocalRoot, anywhere,
     false},
    {"sin.approx.f32", "within 2 pi", "f32", Measure::kAbsolute, 0x1.6a09e6p-21, sine, near},
    {"sin.approx.ftz.f32", "within 2 pi", "f32", Measure::kAbsolute, 0x1.6a09e6p-21, sine, near},
    {"sin.approx.f32", "within 100 pi", "f32", Measure::kAbsolute, 0x1.3b2c47p-15, sine, far},
    {"cos.approx.f32", "within 2 pi", "f32", Measure::kAbsolute, 0x1.6a09e6p-21, cosine, near},
    {"cos.approx.ftz.f32", "within 2 pi", "f32", Measure::kAbsolute, 0x1.6a09e6p-21, cosine, near},
    {"cos.approx.f32", "within 100 pi", "f32", Measure::kAbsolute, 0x1.3b2c47p-15, cosine, far},
    {"ex2.approx.f32", "", "f32", Measure::kUlp, 2, power, anywhere},
    {"ex2.approx.ftz.f32", "", "f32", Measure::kUlp, 2, power, anywhere},
    {"lg2.approx.f32", "between 1/2 and 2", "f32", Measure::kAbsolute, 0x1p-22, logarithm,
     aboutOne},
    {"lg2.approx.ftz.f32", "between 1/2 and 2", "f32", Measure::kAbsolute, 0x1p-22, logarithm,
     aboutOne},
    {"lg2.approx.f32", "elsewhere", "f32", Measure::kRelative, 0x1p-22, logarithm, notAboutOne},
    {"lg2.approx.ftz.f32", "elsewhere", "f32", Measure::kRelative, 0x1p-22, logarithm, notAboutOne},
    {"tanh.approx.f32", "", "f32", Measure::kRelative, 0x1p-11, tangent, anywhere},
    {"tanh.approx.f16", "", "f16", Measure::kAbsolute, 0x1.025135p-11, tangent, anywhere},
    {"tanh.approx.bf16", "", "bf16", Measure::kAbsolute, 0x1p-8, tangent, anywhere},
    {"ex2.approx.f16", "", "f16", Measure::kRelative, 0x1.125fbep-10, power, anywhere},
    {"ex2.approx.ftz.bf16", "", "bf16", Measure::kRelative, 0x1p-7, power, anywhere},
};

std::string nameOf(const Approximation& a) {
    return std::string(a.instruction) + (*a.note ? std::string(" ") + a.note : "");
}

struct Format {
    unsigned bits, mantissa;
    int leastExponent; // of a normal number
    Real largest;
};
Format formatOf(const std::string& type) {
    if (type == "f64")
        return {64, 52, -1022, std::numeric_limits<double>::max()};
    if (type == "f16")
        return {16, 10, -14, 65504};
    if (type == "bf16")
        return {16, 7, -126, 0x1.fep127L};
    return {32, 23, -126, std::numeric_limits<float>::max()};
}
Real valueOf(const Format& format, uint64_t bits) {
    if (format.bits == 64)
        return std::bit_cast<double>(bits);
    if (format.mantissa == 23)
        return std::bit_cast<float>(uint32_t(bits));
    if (format.mantissa == 7)
        return std::bit_cast<float>(uint32_t(bits) << 16);
    const int exponent = int(bits >> 10 & 31);
    const auto fraction = Real(bits & 1023);
    Real value = exponent == 31  ? (fraction != 0 ? NAN : INFINITY)
                 : exponent == 0 ? std::ldexp(fraction, -24)
                                 : std::ldexp(1024 + fraction, exponent - 25);
    return bits >> 15 & 1 ? -value : value;
}
bool isNormal(const Format& format, Real value) {
    return std::isfinite(value) && std::fabs(value) >= std::ldexp(Real(1), format.leastExponent) &&
           std::fabs(value) <= format.largest;
}

// The arguments are equal for every device: one bit pattern from each of equal parts of all
// patterns, and a random pattern for the second operand.
uint64_t argumentBits(const Format& format, unsigned operand, uint64_t index, uint64_t samples) {
    const uint64_t last = ~uint64_t(0) >> (64 - format.bits);
    const uint64_t step = std::max<uint64_t>(1, last / samples);
    uint64_t mixed = (index + 1 + operand) * 0x9e3779b97f4a7c15u;
    mixed = (mixed ^ mixed >> 29) * 0xbf58476d1ce4e5b9u;
    mixed ^= mixed >> 32;
    return operand == 0 ? index * step + mixed % step : mixed & last;
}

std::string kernelOf(const Approximation& a) {
    const Format format = formatOf(a.type);
    const std::string width = std::to_string(format.bits), bytes = std::to_string(format.bits / 8);
    std::ostringstream text;
    text << ".version 7.8\n.target sm_90\n.address_size 64\n"
         << ".visible .entry run(.param .u64 a, .param .u64 b, .param .u64 d, .param .u32 n)\n{\n"
         << ".reg .pred %p;\n.reg .b32 %i, %n, %t, %c;\n.reg .b64 %a, %b, %d, %o;\n"
         << ".reg .b" << width << " %x, %y, %r;\n"
         << "mov.u32 %t, %tid.x;\nmov.u32 %c, %ctaid.x;\nmov.u32 %i, %ntid.x;\n"
         << "mad.lo.u32 %i, %c, %i, %t;\nld.param.u32 %n, [n];\nsetp.ge.u32 %p, %i, %n;\n"
         << "@%p ret;\nmul.wide.u32 %o, %i, " << bytes << ";\nld.param.u64 %a, [a];\n"
         << "ld.param.u64 %b, [b];\nld.param.u64 %d, [d];\nadd.u64 %a, %a, %o;\n"
         << "add.u64 %b, %b, %o;\nadd.u64 %d, %d, %o;\nld.global.b" << width << " %x, [%a];\n";
    if (!a.function)
        text << "ld.global.b" << width << " %y, [%b];\n";
    text << a.instruction << " %r, %x" << (a.function ? "" : ", %y") << ";\nst.global.b" << width
         << " [%d], %r;\nret;\n}\n";
    return text.str();
}

struct Worst {
    double error = 0; // infinite: a result was, or NaN, where the function is not
    uint64_t arguments[2] = {};
    uint64_t result = 0;
    uint64_t counted = 0;

    void take(const Worst& other) {
        counted += other.counted;
        if (other.error > error) {
            error = other.error;
            std::copy_n(other.arguments, 2, arguments);
            result = other.result;
        }
    }
};

// One result.
Worst errorOf(const Approximation& a, const Format& format, const uint64_t (&arguments)[2],
              uint64_t result) {
    const Real x = valueOf(format, arguments[0]);
    const Real y = a.function ? x : valueOf(format, arguments[1]);
    if (!isNormal(format, x) || !isNormal(format, y) || !a.holds(y))
        return {};
    const Real truth = a.function ? a.function(x) : x / y;
    const bool countsBelow = a.measure == Measure::kAbsolute;
    if (!std::isfinite(truth) || (!countsBelow && !isNormal(format, truth)))
        return {};
    const Real difference = std::fabs(valueOf(format, result) - truth);
    Real unit = 1;
    if (a.measure == Measure::kRelative)
        unit = std::fabs(truth);
    else if (a.measure == Measure::kUlp)
        unit = std::ldexp(Real(1), std::ilogb(truth) - int(format.mantissa));
    Worst worst;
    worst.error = std::isfinite(difference) ? double(difference / unit) : HUGE_VAL;
    std::copy_n(arguments, 2, worst.arguments);
    worst.result = result;
    worst.counted = 1;
    return worst;
}

class Meter {
public:
    Worst measure(const Approximation& a, uint64_t samples) {
        const Format format = formatOf(a.type);
        if (format.bits == 16)
            samples = 65536;
        CUmodule module = nullptr;
        CUfunction function = nullptr;
        if (driver_.cuModuleLoadDataEx(&module, kernelOf(a).c_str(), 0, nullptr, nullptr) !=
                CUDA_SUCCESS ||
            driver_.cuModuleGetFunction(&function, module, "run") != CUDA_SUCCESS)
            quit(1, std::string("the driver refuses ") + a.instruction);
        Worst worst;
        for (uint64_t first = 0; first < samples; first += kChunk)
            worst.take(chunk(a, format, function, first, samples));
        driver_.cuModuleUnload(module);
        return worst;
    }
    std::string device() const { return driver_.describe(); }

private:
    static constexpr uint64_t kChunk = uint64_t(1) << 20;

    Worst chunk(const Approximation& a, const Format& format, CUfunction function, uint64_t first,
                uint64_t samples) {
        const unsigned count = unsigned(std::min(kChunk, samples - first)), bytes = format.bits / 8;
        std::vector<uint8_t> data[2], results(size_t(count) * bytes);
        const unsigned operands = a.function ? 1 : 2;
        for (unsigned k = 0; k < operands; ++k)
            data[k].resize(size_t(count) * bytes);
        inParallel(count, [&](unsigned i) {
            for (unsigned k = 0; k < operands; ++k) {
                const uint64_t bits = argumentBits(format, k, first + i, samples);
                std::copy_n(reinterpret_cast<const uint8_t*>(&bits), bytes,
                            &data[k][size_t(i) * bytes]);
            }
        });
        for (unsigned k = 0; k < operands; ++k)
            driver_.copyIn(buffers_[k], data[k].data(), data[k].size());
        unsigned n = count;
        void* params[] = {&buffers_[0], &buffers_[1], &buffers_[2], &n};
        if (driver_.cuLaunchKernel(function, (count + 255) / 256, 1, 1, 256, 1, 1, 0, nullptr,
                                   params, nullptr) != CUDA_SUCCESS ||
            !driver_.copyOut(results.data(), buffers_[2], results.size()))
            quit(1, std::string("cannot run ") + a.instruction);
        const auto at = [&](const std::vector<uint8_t>& from, unsigned i) {
            uint64_t bits = 0;
            std::copy_n(&from[size_t(i) * bytes], bytes, reinterpret_cast<uint8_t*>(&bits));
            return bits;
        };
        std::vector<Worst> worst(threads());
        inParallel(count, [&](unsigned i, unsigned thread) {
            const uint64_t arguments[2] = {at(data[0], i), operands == 2 ? at(data[1], i) : 0};
            worst[thread].take(errorOf(a, format, arguments, at(results, i)));
        });
        for (unsigned i = 1; i < worst.size(); ++i)
            worst[0].take(worst[i]);
        return worst[0];
    }

    static unsigned threads() { return std::max(1u, std::thread::hardware_concurrency()); }
    template <class Body>
    static void inParallel(unsigned count, const Body& body) {
        std::vector<std::thread> workers;
        const unsigned parts = threads();
        for (unsigned part = 0; part < parts; ++part)
            workers.emplace_back([=, &body] {
                const auto end = unsigned(uint64_t(count) * (part + 1) / parts);
                for (auto i = unsigned(uint64_t(count) * part / parts); i < end; ++i)
                    if constexpr (std::is_invocable_v<Body, unsigned, unsigned>)
                        body(i, part);
                    else
                        body(i);
            });
        for (std::thread& worker : workers)
            worker.join();
    }

    Driver driver_;
    CUdeviceptr buffers_[3] = {driver_.allocate(kChunk * 8), driver_.allocate(kChunk * 8),
                               driver_.allocate(kChunk * 8)};
};

std::map<std::string, double> readErrors(const std::string& file, std::string& device) {
    std::map<std::string, double> errors;
    std::ifstream in(file);
    if (!in)
        quit(1, "cannot read " + file);
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with("# device: "))
            device = line.substr(10);
        const size_t tab = line.find('\t'), last = line.rfind('\t');
        if (line.empty() || line[0] == '#' || tab == std::string::npos)
            continue;
        errors[line.substr(0, tab)] = std::strtod(line.c_str() + last, nullptr);
    }
    return errors;
}

std::string hex(uint64_t value) {
    char text[24];
    std::snprintf(text, sizeof text, "%llx", static_cast<unsigned long long>(value));
    return text;
}

std::vector<std::string> functionNames() {
    std::vector<std::string> names;
    for (const Approximation& a : kFunctions)
        names.push_back(nameOf(a));
    return names;
}

} // namespace

int recordErrors(const std::string& file, unsigned samples, const std::string& only) {
    checkSelection(functionNames(), only);
    Meter meter;
    std::ofstream out(file);
    out << "# Largest errors of the .approx functions, measured by `conformance record-errors`: "
           "name, "
           "measure, the\n# manual's bound (- where it states none), the device's error. See "
           "errors.h.\n"
        << "# device: " << meter.device() << ", " << samples << " arguments each\n";
    for (const Approximation& a : kFunctions) {
        if (nameOf(a).find(only) == std::string::npos)
            continue;
        const Worst worst = meter.measure(a, samples);
        out << nameOf(a) << '\t' << kMeasures[int(a.measure)] << '\t';
        a.isStated ? out << a.bound : out << '-';
        out << '\t' << worst.error << '\n';
        std::printf("%s: %g %s of %llu results, at %s %s -> %s; it may be %g\n", nameOf(a).c_str(),
                    worst.error, kMeasures[int(a.measure)],
                    static_cast<unsigned long long>(worst.counted), hex(worst.arguments[0]).c_str(),
                    hex(worst.arguments[1]).c_str(), hex(worst.result).c_str(), a.bound);
    }
    out.flush();
    return out ? 0 : 1;
}

int checkErrors(const std::string& file, unsigned samples, const std::string& only) {
    checkSelection(functionNames(), only);
    std::string device;
    const std::map<std::string, double> known = readErrors(file, device);
    Meter meter;
    unsigned good = 0, bad = 0;
    for (const Approximation& a : kFunctions) {
        if (nameOf(a).find(only) == std::string::npos)
            continue;
        const auto found = known.find(nameOf(a));
        if (found == known.end()) {
            std::printf("%s: not in the list\n", nameOf(a).c_str());
            ++bad;
            continue;
        }
        const double bound = a.isStated ? a.bound : std::max(a.bound, found->second);
        const Worst worst = meter.measure(a, samples);
        const bool holds = worst.error <= bound && worst.counted > 0;
        ++(holds ? good : bad);
        std::printf("%s: %s: %g %s, %s %g; the recorded device %g\n", holds ? "good" : "TOO FAR",
                    nameOf(a).c_str(), worst.error, kMeasures[int(a.measure)],
                    a.isStated ? "the manual allows" : "it may be", bound, found->second);
        if (!holds)
            std::printf("  at %s %s -> %s\n", hex(worst.arguments[0]).c_str(),
                        hex(worst.arguments[1]).c_str(), hex(worst.result).c_str());
    }
    std::printf("recorded on %s, measured on %s: %u functions within their bounds, %u not\n",
                device.c_str(), meter.device().c_str(), good, bad);
    return bad ? 1 : 0;
}

} // namespace conformance
