// SPDX-License-Identifier: Apache-2.0
// The list of matrix instructions under test. See matrix_cases.h. Source: PTX ISA manual, "Warp
// Level Matrix Multiply-Accumulate Instructions".
#include "matrices/matrix_cases.h"

#include <map>

namespace conformance {

namespace {

std::string text(size_t number) {
    return std::to_string(number);
}

unsigned bitsOf(const std::string& type) {
    static const std::map<std::string, unsigned> kBits = {
        {"f64", 64}, {"f32", 32}, {"s32", 32}, {"tf32", 32}, {"f16", 16}, {"bf16", 16}, {"s8", 8},
        {"u8", 8},   {"e4m3", 8}, {"e5m2", 8}, {"s4", 4},    {"u4", 4},   {"b1", 1}};
    return kBits.at(type);
}

struct Shape {
    unsigned m, n, k;
    std::string name() const { return "m" + text(m) + "n" + text(n) + "k" + text(k); }
};

// Registers of a fragment, which also is an operand of the instruction.
struct Fragment {
    std::string name; // of its first register: a, b, c, d
    std::string type;
    unsigned count = 0;
    std::string registerType() const {
        return type == "f64" ? ".f64" : type == "f32" ? ".f32" : ".b32";
    }
    unsigned bytes() const { return type == "f64" ? 8 : 4; }
    std::string declare() const {
        return ".reg " + registerType() + " " + name + "<" + text(count) + ">;\n";
    }
    std::string list() const {
        std::string all = "{";
        for (unsigned i = 0; i < count; ++i)
            all += (i ? ", " : "") + name + text(i);
        return all + "}";
    }
    std::string load(size_t area) const {
        std::string all;
        for (unsigned i = 0; i < count; ++i)
            all += "ld.global" + registerType() + " " + name + text(i) + ", [own+" +
                   text(area * kAreaBytes + i * bytes()) + "];\n";
        return all;
    }
    std::string store() const {
        std::string all;
        for (unsigned i = 0; i < count; ++i)
            all += "st.global" + registerType() + " [mine+" + text(i * bytes()) + "], " + name +
                   text(i) + ";\n";
        return all;
    }
};

// Elements of a matrix over the lanes, in registers of 32 bits (64 for f64).
Fragment fragment(const char* name, const std::string& type, unsigned elements) {
    return {name, type, elements * bitsOf(type) / 32 / (type == "f64" ? 64 : 32)};
}

class Cases {
public:
    std::vector<MatrixCase> list;

    void mma(const std::string& name, Shape s, const std::string& a, const std::string& b,
             const std::string& c, const std::string& d) {
        // m8n8k4 of halves is four products, one for each eight lanes.
        const unsigned many = s.m * s.n * s.k == 256 && a == "f16" ? 4 : 1;
        const Fragment fa = fragment("a", a, s.m * s.k * many);
        const Fragment fb = fragment("b", b, s.n * s.k * many);
        const Fragment fc = fragment("c", c, s.m * s.n * many);
        const Fragment fd = fragment("d", d, s.m * s.n * many);
        list.push_back({name,
                        fa.declare() + fb.declare() + fc.declare() + fd.declare() + fa.load(0) +
                            fb.load(1) + fc.load(2) + name + " " + fd.list() + ", " + fa.list() +
                            ", " + fb.list() + ", " + fc.list() + ";\n" + fd.store(),
                        {a, b, c}});
    }

    // Registers of a wmma fragment: halves of A and B are in two lanes, or repeated as often as
    // they fit.
    static Fragment wmmaFragment(const char* name, Shape s, const std::string& type) {
        const bool isA = name[0] == 'a', isB = name[0] == 'b';
        if (type == "f16" && (isA || isB))
            return {name, type, 8};
        return fragment(name, type, isA ? s.m * s.k : isB ? s.k * s.n : s.m * s.n);
    }

    static std::string wmmaLoad(const Fragment& f, Shape s, const std::string& layout, size_t area,
                                unsigned elements) {
        const unsigned step = 128 / bitsOf(f.type); // rows begin at multiples of 16 bytes
        const unsigned stride = (elements + step - 1) / step * step;
        return "add.u64 at, in, " + text(area * kAreaBytes) + ";\nwmma.load." + f.name +
               ".sync.aligned." + layout + "." + s.name() + ".global." + f.type + " " + f.list() +
               ", [at], " + text(stride) + ";\n";
    }

    void wmma(const std::string& name, Shape s, const std::string& rowA, const std::string& rowB,
              const std::string& a, const std::string& c, const std::string& d) {
        const Fragment fa = wmmaFragment("a", s, a), fb = wmmaFragment("b", s, a);
        const Fragment fc = wmmaFragment("c", s, c), fd = wmmaFragment("d", s, d);
        // Rows have gaps if there is room.
        const unsigned apart = rowA == rowB && bitsOf(a) >= 8 && a != "f64" ? 128 / bitsOf(a) : 0;
        const std::string rowD = rowA;
        std::string code =
            ".reg .b64 at;\n" + fa.declare() + fb.declare() + fc.declare() + fd.declare();
        code += wmmaLoad(fa, s, rowA, 0, (rowA == "row" ? s.k : s.m) + apart);
        code += wmmaLoad(fb, s, rowB, 1, (rowB == "row" ? s.n : s.k) + apart);
        code += wmmaLoad(fc, s, rowB, 2, rowB == "row" ? s.n : s.m);
        code += name + " " + fd.list() + ", " + fa.list() + ", " + fb.list() + ", " + fc.list() +
                ";\nwmma.store.d.sync.aligned." + rowD + "." + s.name() + ".global." + d +
                " [out], " + fd.list() + ", " + text(rowD == "row" ? s.n : s.m) + ";\n";
        list.push_back({name, code, {a, a, c}});
    }

    // A lane's results.
    void wmmaFragments(Shape s, const std::string& type, const char* which) {
        const Fragment f = wmmaFragment(which, s, type);
        const bool isA = which[0] == 'a', isB = which[0] == 'b';
        for (const std::string row : {"row", "col"}) {
            if ((type == "s4" || type == "b1") && (isA || isB) && row != (isA ? "row" : "col"))
                continue;
            const unsigned down = isB ? s.k : s.m, across = isA ? s.k : s.n;
            list.push_back({"wmma.load." + f.name + "." + row + "." + s.name() + "." + type,
                            ".reg .b64 at;\n" + f.declare() +
                                wmmaLoad(f, s, row, 0, row == "row" ? across : down) + f.store(),
                            {type, "", ""}});
        }
    }

    void rows(unsigned count, bool stores, bool transposes) {
        const Fragment f = {"r", "b16", count};
        const std::string name = std::string(stores ? "stmatrix" : "ldmatrix") +
                                 ".sync.aligned.m8n8.x" + text(count) +
                                 (transposes ? ".trans" : "") + ".shared.b16";
        std::string code = f.declare() + ".reg .b32 w<16>;\n";
        const auto copy = [&](bool out) {
            for (unsigned i = 0; i < 16; ++i) {
                const std::string w = "w" + text(i), at = "+" + text(4 * i) + "]";
                code += out ? "ld.shared.b32 " + w + ", [part" + at + ";\nst.global.b32 [mine" +
                                  at + ", " + w + ";\n"
                            : "ld.global.b32 " + w + ", [own" + at + ";\nst.shared.b32 [part" + at +
                                  ", " + w + ";\n";
            }
        };
        copy(false);
        code += "bar.sync 0;\n";
        if (stores) {
            code += f.load(1) + name + " [row], " + f.list() + ";\nbar.sync 0;\n";
            copy(true);
        } else {
            code += name + " " + f.list() + ", [row];\n" + f.store();
        }
        list.push_back({name, code, {"s8", "s8", ""}, true});
    }
};

void addFloats(Cases& cases) {
    const std::string mma = "mma.sync.aligned.";
    for (const std::string c : {"f16", "f32"})
        for (const std::string d : {"f16", "f32"})
            for (const std::string rows : {"row.row", "row.col", "col.row", "col.col"})
                cases.mma(mma + "m8n8k4." + rows + "." + d + ".f16.f16." + c, {8, 8, 4}, "f16",
                          "f16", c, d);
    for (const Shape s : {Shape{16, 8, 8}, Shape{16, 8, 16}}) {
        for (const std::string c : {"f16", "f32"})
            for (const std::string d : {"f16", "f32"})
                cases.mma(mma + s.name() + ".row.col." + d + ".f16.f16." + c, s, "f16", "f16", c,
                          d);
        cases.mma(mma + s.name() + ".row.col.f32.bf16.bf16.f32", s, "bf16", "bf16", "f32", "f32");
    }
    for (const Shape s : {Shape{16, 8, 4}, Shape{16, 8, 8}})
        cases.mma(mma + s.name() + ".row.col.f32.tf32.tf32.f32", s, "tf32", "tf32", "f32", "f32");
    for (const Shape s : {Shape{8, 8, 4}, Shape{16, 8, 4}, Shape{16, 8, 8}, Shape{16, 8, 16}})
        cases.mma(mma + s.name() + ".row.col.f64.f64.f64.f64", s, "f64", "f64", "f64", "f64");
    for (const Shape s : {Shape{16, 8, 16}, Shape{16, 8, 32}})
        for (const std::string a : {"e4m3", "e5m2"})
            for (const std::string b : {"e4m3", "e5m2"})
                for (const std::string c : {"f32", "f16"})
                    cases.mma(mma + s.name() + ".row.col." + c + "." + a + "." + b + "." + c, s, a,
                              b, c, c);
}

void addIntegers(Cases& cases) {
    const std::string mma = "mma.sync.aligned.";
    for (const std::string bits : {"8", "4"})
        for (const Shape s : {Shape{8, 8, 16}, Shape{16, 8, 16}, Shape{16, 8, 32}})
            for (const char* saturates : {"", ".satfinite"})
                for (const std::string a : {"u", "s"})
                    for (const std::string b : {"u", "s"}) {
                        Shape shape = s;
                        if (bits == "4")
                            shape.k *= 2;
                        cases.mma(mma + shape.name() + ".row.col" + saturates + ".s32." + a + bits +
                                      "." + b + bits + ".s32",
                                  shape, a + bits, b + bits, "s32", "s32");
                    }
    for (const Shape s : {Shape{8, 8, 128}, Shape{16, 8, 128}, Shape{16, 8, 256}})
        for (const std::string operation : {"xor", "and"})
            cases.mma(mma + s.name() + ".row.col.s32.b1.b1.s32." + operation + ".popc", s, "b1",
                      "b1", "s32", "s32");
}

constexpr Shape kWide[] = {{16, 16, 16}, {8, 32, 16}, {32, 8, 16}};

void addWmmaFloats(Cases& cases) {
    const std::string mma = "wmma.mma.sync.aligned.";
    for (const std::string rowA : {"row", "col"})
        for (const std::string rowB : {"row", "col"}) {
            const std::string rows = rowA + "." + rowB + ".";
            for (const Shape s : kWide) {
                for (const std::string c : {"f16", "f32"})
                    for (const std::string d : {"f16", "f32"})
                        if (c == d || rows == "row.col.")
                            cases.wmma(mma + rows + s.name() + "." + d + "." + c, s, rowA, rowB,
                                       "f16", c, d);
                cases.wmma(mma + rows + s.name() + ".f32.bf16.bf16.f32", s, rowA, rowB, "bf16",
                           "f32", "f32");
                for (const std::string a : {"u8", "s8"})
                    for (const std::string saturates : {"", ".satfinite"})
                        if (saturates.empty() || rows == "row.col.")
                            cases.wmma(mma + rows + s.name() + ".s32." + a + "." + a + ".s32" +
                                           saturates,
                                       s, rowA, rowB, a, "s32", "s32");
            }
            cases.wmma(mma + rows + "m16n16k8.f32.tf32.tf32.f32", {16, 16, 8}, rowA, rowB, "tf32",
                       "f32", "f32");
            for (const std::string rounding : {"", ".rn", ".rz", ".rm", ".rp"})
                if (rounding.empty() || rows == "row.col.")
                    cases.wmma(mma + rows + "m8n8k4" + rounding + ".f64.f64.f64.f64", {8, 8, 4},
                               rowA, rowB, "f64", "f64", "f64");
        }
    for (const std::string a : {"u4", "s4"})
        for (const char* saturates : {"", ".satfinite"})
            cases.wmma(mma + "row.col.m8n8k32.s32." + a + "." + a + ".s32" + saturates, {8, 8, 32},
                       "row", "col", a, "s32", "s32");
    for (const std::string operation : {"xor", "and"})
        cases.wmma("wmma.mma." + operation + ".popc.sync.aligned.row.col.m8n8k128.s32.b1.b1.s32",
                   {8, 8, 128}, "row", "col", "b1", "s32", "s32");
}

void addFragments(Cases& cases) {
    for (const Shape s : kWide) {
        for (const char* which : {"a", "b"})
            for (const std::string type : {"f16", "bf16", "s8"})
                cases.wmmaFragments(s, type, which);
        for (const std::string type : {"f16", "f32", "s32"})
            cases.wmmaFragments(s, type, "c");
    }
    const struct {
        Shape shape;
        const char *type, *result;
    } kOthers[] = {{{16, 16, 8}, "tf32", "f32"},
                   {{8, 8, 4}, "f64", "f64"},
                   {{8, 8, 32}, "s4", "s32"},
                   {{8, 8, 128}, "b1", "s32"}};
    for (const auto& other : kOthers) {
        cases.wmmaFragments(other.shape, other.type, "a");
        cases.wmmaFragments(other.shape, other.type, "b");
        cases.wmmaFragments(other.shape, other.result, "c");
    }
}

} // namespace

const std::vector<MatrixCase>& allMatrixCases() {
    static const std::vector<MatrixCase> all = [] {
        Cases cases;
        addFloats(cases);
        addIntegers(cases);
        addWmmaFloats(cases);
        addFragments(cases);
        for (const unsigned count : {1u, 2u, 4u})
            for (const bool transposes : {false, true}) {
                cases.rows(count, false, transposes);
                cases.rows(count, true, transposes);
            }
        const std::string move = "movmatrix.sync.aligned.m8n8.trans.b16";
        cases.list.push_back({move,
                              ".reg .b32 a, d;\nld.global.b32 a, [own];\n" + move +
                                  " d, a;\nst.global.b32 [mine], d;\n",
                              {"s8", "", ""}});
        return std::move(cases.list);
    }();
    return all;
}

std::string matrixKernel(const MatrixCase& test) {
    std::string code = ".version 8.7\n.target sm_90\n.address_size 64\n";
    if (test.usesShared)
        code += ".shared .align 64 .b8 shared[2048];\n";
    code += ".visible .entry k(.param .u64 p0, .param .u64 p1) {\n"
            ".reg .b64 in, own, out, mine, wide;\n.reg .b32 problem, lane;\n"
            "ld.param.u64 in, [p0];\nld.param.u64 out, [p1];\n"
            "mov.u32 problem, %ctaid.x;\nmov.u32 lane, %tid.x;\n"
            "mul.wide.u32 wide, problem, " +
            text(kProblemBytes) +
            ";\nadd.u64 in, in, wide;\n"
            "mul.wide.u32 wide, problem, " +
            text(kMatrixResultBytes) +
            ";\nadd.u64 out, out, wide;\n"
            "mul.wide.u32 wide, lane, 64;\nadd.u64 own, in, wide;\nadd.u64 mine, out, wide;\n";
    if (test.usesShared)
        code += ".reg .b32 row, part, base;\nmov.u32 base, shared;\n"
                "mad.lo.u32 part, lane, 64, base;\nmad.lo.u32 row, lane, 7, problem;\n"
                "and.b32 row, row, 127;\nmad.lo.u32 row, row, 16, base;\n";
    return code + test.code + "ret;\n}\n";
}

} // namespace conformance
