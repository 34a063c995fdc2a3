// SPDX-License-Identifier: Apache-2.0
// The container of glTF: the JSON tree, buffers, and typed access to them through accessors, with
// every offset and count checked.
#pragma once

#include "model.h"

#include <nlohmann/json.hpp>

namespace model::gltf {

using Json = nlohmann::json;

// A member of an object; null if missing (or if `object` is not an object).
const Json* find(const Json& object, const char* key);
// `value` itself; ModelError unless it is an array.
const Json& array(const Json& value, const char* key);
double number(const Json& object, const char* key, double fallback);
// A whole number from 0; ModelError for other members.
uint64_t index(const Json& object, const char* key, uint64_t fallback);

class File {
public:
    // Reads .gltf or .glb, distinguished by their first bytes. Throws ModelError.
    explicit File(const std::string& path);

    const Json& root() const { return root_; }
    // The element of the root's array `list` with the index `reference`.
    const Json& element(const char* list, const Json& reference) const;
    // All values of an accessor with `components` numbers an element, normalised integers
    // converted to their range.
    std::vector<double> read(const Json& accessor, unsigned components);
    // The bytes of an element of "images".
    std::string image(const Json& reference);

private:
    void splitGlb(const std::string& bytes, std::string& json);
    const std::string& buffer(const Json& reference);
    std::string viewBytes(const Json& reference);

    std::string folder_;
    Json root_;
    std::string binaryChunk_;
    bool hasBinaryChunk_ = false;
    std::vector<std::string> buffers_; // the buffers already read
    std::vector<bool> isRead_;
};

} // namespace model::gltf
