// SPDX-License-Identifier: Apache-2.0
// Keys of stored code: digests of all inputs of the code.
#pragma once

#include "compiler/compiler.h"

#include <llvm/Support/BLAKE3.h>

namespace sunstone::compiler {

class Digest {
public:
    void add(std::string_view text) {
        add(uint64_t(text.size()));
        hash_.update(llvm::StringRef(text.data(), text.size()));
    }
    void add(uint64_t value) {
        hash_.update(
            llvm::ArrayRef<uint8_t>(reinterpret_cast<const uint8_t*>(&value), sizeof value));
    }
    std::string take() {
        const auto bytes = hash_.final<16>();
        return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    }

private:
    llvm::BLAKE3 hash_;
};

inline void addRules(Digest& digest, const PipelineRules& rules) {
    // Names every field, so that a new field does not compile until it is part of the key.
    const auto& [launchParams, exceptionFlags, primitiveTypeFlags, traversableGraphFlags,
                 motionBlur, optix7, optix6] = rules;
    const auto& [numPayloadValues, numAttributeValues] = optix7;
    const auto& [attributeBytes, exceptions, maxCallableDepth] = optix6;
    digest.add(launchParams);
    for (const uint64_t value :
         {uint64_t(numPayloadValues), uint64_t(numAttributeValues), uint64_t(exceptionFlags),
          uint64_t(primitiveTypeFlags), uint64_t(traversableGraphFlags), uint64_t(motionBlur),
          uint64_t(attributeBytes), uint64_t(exceptions), uint64_t(maxCallableDepth)})
        digest.add(value);
}

inline void addRules(Digest& digest, const ModuleRules& rules) {
    const auto& [payloadTypes, boundValues, attributes] = rules;
    digest.add(uint64_t(payloadTypes.size()));
    for (const PayloadType& type : payloadTypes) {
        digest.add(uint64_t(type.words.size()));
        for (uint32_t word : type.words)
            digest.add(uint64_t(word));
    }
    digest.add(uint64_t(boundValues.size()));
    for (const BoundValue& value : boundValues) {
        digest.add(value.offset);
        digest.add(std::string_view(reinterpret_cast<const char*>(value.bytes.data()),
                                    value.bytes.size()));
    }
    digest.add(uint64_t(attributes.size()));
    for (const AttributePlace& attribute : attributes) {
        digest.add(attribute.name);
        digest.add(uint64_t(attribute.offset));
    }
}

} // namespace sunstone::compiler
