// SPDX-License-Identifier: Apache-2.0
// See approximations.h. Each function reduces its argument to a short interval about zero and
// evaluates a polynomial there. The coefficients interpolate the function (divided by its leading
// term) at Chebyshev nodes of the interval, rounded to single precision.
#include "compiler/passes/approximations.h"

namespace sunstone::compiler {

namespace {

using llvm::Value;

class Writer {
public:
    Writer(Unit& unit, llvm::Function& function, bool ftz)
        : unit_(unit), function_(function), builder_(unit.context()), ftz_(ftz) {
        builder_.SetInsertPoint(llvm::BasicBlock::Create(unit.context(), "", &function));
    }

    void sine(bool cosine) {
        Value* x = function_.getArg(0);
        // Huge, infinite and NaN arguments take the library's function.
        constexpr double kLimit = 65536.0;
        auto* fast = llvm::BasicBlock::Create(unit_.context(), "fast", &function_);
        auto* slow = llvm::BasicBlock::Create(unit_.context(), "slow", &function_);
        builder_.CreateCondBr(builder_.CreateFCmpOLT(magnitude(x), number(kLimit)), fast, slow,
                              likely());
        builder_.SetInsertPoint(slow);
        builder_.CreateRet(builder_.CreateCall(
            unit_.helper(cosine ? "sunstone_cos_f32" : "sunstone_sin_f32", single(), {single()}),
            {x}));

        // x = k * pi/2 + r with pi/2 in three parts: k has 16 bits, so the first step is exact.
        builder_.SetInsertPoint(fast);
        Value* k = unary(llvm::Intrinsic::roundeven, builder_.CreateFMul(x, number(0x1.45f306p-1)));
        Value* r = fma(k, number(-0x1.921fb6p+0), x);
        r = fma(k, number(0x1.777a5cp-25), r);
        r = fma(k, number(0x1.ee59dap-50), r);
        Value* z = builder_.CreateFMul(r, r);
        Value* sine = polynomial(z, {-0x1.555552p-3, 0x1.110bf6p-7, -0x1.9aaea8p-13});
        sine = fma(builder_.CreateFMul(sine, z), r, r);
        Value* cosineOf = polynomial(z, {-0.5, 0x1.555554p-5, -0x1.6c12aap-10, 0x1.9bc2fp-16});
        cosineOf = fma(cosineOf, z, number(1.0));

        Value* quadrant = builder_.CreateFPToSI(k, word());
        if (cosine)
            quadrant = builder_.CreateAdd(quadrant, builder_.getInt32(1));
        Value* result = builder_.CreateSelect(builder_.CreateTrunc(quadrant, builder_.getInt1Ty()),
                                              cosineOf, sine);
        Value* sign = builder_.CreateShl(builder_.CreateAnd(quadrant, uint64_t(2)), uint64_t(30));
        result = asFloat(builder_.CreateXor(asWord(result), sign));
        if (!cosine) // preserves the sign of zero, and subnormals
            result = builder_.CreateSelect(builder_.CreateFCmpOLT(magnitude(x), number(0x1p-12)), x,
                                           result);
        builder_.CreateRet(result);
    }

    void exponential() { builder_.CreateRet(exponentialOf(function_.getArg(0))); }

    void logarithm() {
        Value* x = function_.getArg(0);
        Value* scaled = x;
        Value* bias = number(0.0);
        if (!ftz_) {
            Value* subnormal = builder_.CreateFCmpOLT(x, number(0x1p-126));
            scaled = builder_.CreateSelect(subnormal, builder_.CreateFMul(x, number(0x1p24)), x);
            bias = builder_.CreateSelect(subnormal, number(-24.0), bias);
        }
        // x = 2^e * (1 + f) with 1 + f in [sqrt(1/2), sqrt(2)): the integer subtraction makes the
        // exponent step at sqrt(2).
        Value* bits = asWord(scaled);
        Value* offset = builder_.CreateSub(bits, builder_.getInt32(0x3f3504f3));
        Value* exponent = builder_.CreateAShr(offset, uint64_t(23));
        Value* mantissa =
            asFloat(builder_.CreateSub(bits, builder_.CreateShl(exponent, uint64_t(23))));
        Value* e = builder_.CreateFAdd(builder_.CreateSIToFP(exponent, single()), bias);
        Value* f = builder_.CreateFSub(mantissa, number(1.0));
        Value* series = polynomial(f, {0x1.715476p+0, -0x1.715474p-1, 0x1.ec73dep-2, -0x1.715994p-2,
                                       0x1.26d01cp-2, -0x1.e9d1e6p-3, 0x1.ba8738p-3, -0x1.a59aeap-3,
                                       0x1.f841dcp-4});
        Value* result = fma(series, f, e);
        // NaN for NaN and below zero, -infinity for zeros, infinity for itself.
        const double infinity = __builtin_inf();
        result = builder_.CreateSelect(builder_.CreateFCmpOLT(x, number(infinity)), result, x);
        Value* special =
            builder_.CreateSelect(builder_.CreateFCmpOEQ(x, number(0.0)), number(-infinity),
                                  llvm::ConstantFP::getQNaN(single()));
        builder_.CreateRet(
            builder_.CreateSelect(builder_.CreateFCmpOGT(x, number(0.0)), result, special));
    }

    // Near zero a polynomial, else 1 - 2 / (e^2x + 1), with the sign restored.
    void tangent() {
        Value* x = function_.getArg(0);
        Value* size = magnitude(x);
        Value* z = builder_.CreateFMul(x, x);
        Value* near = polynomial(
            z, {-0x1.555552p-2, 0x1.110d38p-3, -0x1.b8f152p-5, 0x1.56271cp-6, -0x1.851762p-8});
        near = fma(builder_.CreateFMul(near, z), x, x);
        near = builder_.CreateSelect(builder_.CreateFCmpOLT(size, number(0x1p-12)), x, near);
        Value* power = exponentialOf(builder_.CreateFMul(size, number(0x1.715476p+1)));
        Value* far = builder_.CreateFSub(
            number(1.0), builder_.CreateFDiv(number(2.0), builder_.CreateFAdd(power, number(1.0))));
        far = builder_.CreateBinaryIntrinsic(llvm::Intrinsic::copysign, far, x);
        builder_.CreateRet(
            builder_.CreateSelect(builder_.CreateFCmpOLT(size, number(0.625)), near,
                                  builder_.CreateSelect(builder_.CreateFCmpUNO(x, x), x, far)));
    }

private:
    llvm::Type* single() { return builder_.getFloatTy(); }
    llvm::Type* word() { return builder_.getInt32Ty(); }
    llvm::Constant* number(double value) { return llvm::ConstantFP::get(single(), value); }
    Value* asWord(Value* value) { return builder_.CreateBitCast(value, word()); }
    Value* asFloat(Value* value) { return builder_.CreateBitCast(value, single()); }
    Value* unary(llvm::Intrinsic::ID id, Value* value) {
        return builder_.CreateUnaryIntrinsic(id, value);
    }
    Value* magnitude(Value* value) { return unary(llvm::Intrinsic::fabs, value); }
    Value* fma(Value* a, Value* b, Value* c) {
        return builder_.CreateIntrinsic(llvm::Intrinsic::fma, {single()}, {a, b, c});
    }
    llvm::MDNode* likely() {
        llvm::Type* type = word();
        return llvm::MDNode::get(
            unit_.context(), {llvm::MDString::get(unit_.context(), "branch_weights"),
                              llvm::ConstantAsMetadata::get(llvm::ConstantInt::get(type, 1 << 20)),
                              llvm::ConstantAsMetadata::get(llvm::ConstantInt::get(type, 1))});
    }

    // c[0] + c[1] z + ...
    Value* polynomial(Value* z, std::initializer_list<double> coefficients) {
        Value* sum = nullptr;
        for (size_t i = coefficients.size(); i-- > 0;) {
            llvm::Constant* c = number(coefficients.begin()[i]);
            sum = sum ? fma(sum, z, c) : static_cast<Value*>(c);
        }
        return sum;
    }

    Value* powerOfTwo(Value* exponent) {
        return asFloat(
            builder_.CreateShl(builder_.CreateAdd(exponent, builder_.getInt32(127)), uint64_t(23)));
    }

    // 2^x = 2^k * 2^f, f in [-1/2, 1/2]. The power of two is multiplied in two steps, so that only
    // the last one rounds a subnormal result.
    Value* exponentialOf(Value* x) {
        Value* bounded =
            builder_.CreateSelect(builder_.CreateFCmpOGT(x, number(-151.0)), x, number(-151.0));
        bounded = builder_.CreateSelect(builder_.CreateFCmpOLT(bounded, number(129.0)), bounded,
                                        number(129.0));
        Value* k = unary(llvm::Intrinsic::roundeven, bounded);
        Value* f = builder_.CreateFSub(bounded, k);
        Value* series = polynomial(f, {1.0, 0x1.62e43p-1, 0x1.ebfbep-3, 0x1.c6af6cp-5,
                                       0x1.3b2a54p-7, 0x1.5f089p-10, 0x1.44138ap-13});
        Value* whole = builder_.CreateFPToSI(k, word());
        Value* half = builder_.CreateAShr(whole, uint64_t(1));
        Value* result = builder_.CreateFMul(series, powerOfTwo(half));
        result = builder_.CreateFMul(result, powerOfTwo(builder_.CreateSub(whole, half)));
        if (ftz_)
            result = builder_.CreateSelect(builder_.CreateFCmpOLT(x, number(-126.0)), number(0.0),
                                           result);
        return builder_.CreateSelect(builder_.CreateFCmpUNO(x, x), x, result);
    }

    Unit& unit_;
    llvm::Function& function_;
    llvm::IRBuilder<> builder_;
    bool ftz_;
};

} // namespace

llvm::Function* approximation(Unit& unit, std::string_view opcode, bool ftz) {
    const std::string name = "approx." + std::string(opcode) + (ftz ? ".ftz" : "");
    if (llvm::Function* existing = unit.module().getFunction(name))
        return existing;
    llvm::Type* single = llvm::Type::getFloatTy(unit.context());
    auto* function =
        llvm::Function::Create(llvm::FunctionType::get(single, {single}, false),
                               llvm::GlobalValue::InternalLinkage, name, unit.module());
    function->addFnAttr(llvm::Attribute::NoUnwind);
    function->addFnAttr(llvm::Attribute::InlineHint);
    if (ftz)
        function->addFnAttr(kAnyModeAttribute);
    Writer writer(unit, *function, ftz);
    if (opcode == "sin" || opcode == "cos")
        writer.sine(opcode == "cos");
    else if (opcode == "ex2")
        writer.exponential();
    else if (opcode == "lg2")
        writer.logarithm();
    else
        writer.tangent();
    return function;
}

} // namespace sunstone::compiler
