// SPDX-License-Identifier: Apache-2.0
// FunctionTranslator: from the operation of an opcode to the member function that translates it.
#include "compiler/translate/function_translator.h"

namespace sunstone::compiler {

struct FunctionTranslator::Members {
    using T = FunctionTranslator;
    using O = ptx::Operation;
    struct Row {
        O operation;
        void (T::*member)(const ptx::Instruction&);
    };
    // In the order of ptx::Operation, without kUnknown.
    static constexpr Row kRows[] = {
        {O::kMove, &T::move},
        {O::kLoad, &T::load},
        {O::kStore, &T::store},
        {O::kAtomic, &T::atomic},
        {O::kConvertAddress, &T::convertAddress},
        {O::kTestAddressSpace, &T::testAddressSpace},
        {O::kFence, &T::fence},
        {O::kSleep, &T::sleep},
        {O::kNothing, &T::noOperation},
        {O::kAdd, &T::add},
        {O::kSubtract, &T::subtract},
        {O::kMultiply, &T::multiply},
        {O::kMultiplyAdd, &T::multiplyAdd},
        {O::kMultiply24, &T::multiply24},
        {O::kFusedMultiplyAdd, &T::fusedMultiplyAdd},
        {O::kDivide, &T::divide},
        {O::kRemainder, &T::remainder},
        {O::kNegate, &T::negate},
        {O::kAbsolute, &T::absolute},
        {O::kMinimum, &T::minimum},
        {O::kSumAbsoluteDifference, &T::sumAbsoluteDifference},
        {O::kDotProduct, &T::dotProduct},
        {O::kReciprocal, &T::reciprocal},
        {O::kSquareRoot, &T::squareRoot},
        {O::kReciprocalSquareRoot, &T::reciprocalSquareRoot},
        {O::kTranscendental, &T::transcendental},
        {O::kCopySign, &T::copySign},
        {O::kTestProperty, &T::testProperty},
        {O::kLogic, &T::logic},
        {O::kLogicNot, &T::logicNot},
        {O::kLookup3, &T::lookup3},
        {O::kShift, &T::shift},
        {O::kFunnelShift, &T::funnelShift},
        {O::kExtractField, &T::extractField},
        {O::kInsertField, &T::insertField},
        {O::kFindBit, &T::findBit},
        {O::kCountBits, &T::countBits},
        {O::kFindNthSet, &T::findNthSet},
        {O::kFieldMask, &T::fieldMask},
        {O::kPermute, &T::permute},
        {O::kSetPredicate, &T::setPredicate},
        {O::kSetValue, &T::setValue},
        {O::kSelect, &T::select},
        {O::kSelectBySign, &T::selectBySign},
        {O::kConvert, &T::convert},
        {O::kSampleTexture, &T::sampleTexture},
        {O::kQueryTexture, &T::queryTexture},
        {O::kLoadSurface, &T::loadSurface},
        {O::kStoreSurface, &T::storeSurface},
        {O::kReduceSurface, &T::reduceSurface},
        {O::kBranch, &T::branch},
        {O::kBranchIndexed, &T::branchIndexed},
        {O::kCall, &T::call},
        {O::kReturn, &T::returnFrom},
        {O::kExit, &T::exitThread},
        {O::kTrap, &T::trap},
        {O::kBarrier, &T::barrier},
        {O::kVote, &T::vote},
        {O::kMatch, &T::match},
        {O::kShuffle, &T::shuffle},
        {O::kActiveMask, &T::activeMask},
        {O::kReduceWarp, &T::reduceWarp},
        {O::kElect, &T::elect},
        {O::kSaveStack, &T::saveStack},
        {O::kRestoreStack, &T::restoreStack},
        {O::kAllocateStack, &T::allocateStack},
        {O::kCopyAsync, &T::copyAsync},
        {O::kBarrierObject, &T::barrierObject},
        {O::kWideMatrices, &T::wideMatrices},
        {O::kMultiplyMatrices, &T::multiplyMatrices},
        {O::kMoveMatrixRows, &T::moveMatrixRows},
        {O::kTransposeMatrix, &T::transposeMatrix},
        {O::kVideoScalar, &T::videoScalar},
        {O::kVideoMultiplyAdd, &T::videoMultiplyAdd},
        {O::kVideoPacked, &T::videoPacked},
    };

    static constexpr bool isComplete() {
        for (size_t i = 0; i < std::size(kRows); ++i)
            if (size_t(kRows[i].operation) != i + 1)
                return false;
        return std::size(kRows) + 1 == size_t(O::kCount);
    }
};

void FunctionTranslator::dispatch(const ptx::Instruction& instruction) {
    static_assert(Members::isComplete());
    if (unit_.isGpu() && translateNative(instruction))
        return;
    const ptx::Opcode& facts = *instruction.facts;
    if (facts.operation == ptx::Operation::kUnknown)
        failAt(ErrorCode::kNotSupported, instruction.location, "instruction \"",
               instruction.fullOpcode(), "\" is not supported (in function \"", source_.name,
               "\")");
    if (facts.isPacked() && (instruction.has("u16x2") || instruction.has("s16x2")))
        return packedArithmetic(instruction);
    (this->*Members::kRows[size_t(facts.operation) - 1].member)(instruction);
}

} // namespace sunstone::compiler
