// SPDX-License-Identifier: Apache-2.0
// Sends a context to other ranks: the whole context at first, then the changes. A copy holds the
// state that the application has set, without the calls that set it, so objects that no program can
// reach are not sent. The receiver is replica.h.
#pragma once

#include "api/optix6/context.h"

#include <map>
#include <set>

namespace sunstone::optix6 {

// A message of changes is a sequence of records. Each begins with one of these.
enum class Record : uint8_t {
    kText,     // digest, PTX
    kObject,   // number, kind, data for its creation, fields
    kScope,    // number, variables
    kContents, // number of a buffer, its bytes
    kGone,     // number
    kContext,  // fields
};
constexpr uint64_t kContextNumber = 1; // no object has it; for its scope

class Writer;

class SceneSender {
public:
    // The changes since the last call. The scene is up to date (Scene::update), and no program
    // runs.
    std::string changes(Context& context);

private:
    struct Sent {
        std::string make, fields, scope;
        uint64_t version = ~uint64_t(0), hash = 0; // of a buffer's contents
    };
    void writeObject(Writer& out, Object& object);
    void writeScope(Writer& out, uint64_t number, const Scoped& object, Sent& sent);
    void writeContents(Writer& out, const Buffer& buffer, Sent& sent);
    void writeText(Writer& out, const ProgramCode& code);

    std::map<uint64_t, Sent> sent_;
    std::set<std::string> texts_; // by digest
    // Objects visited in the current call.
    std::set<uint64_t> seen_;
    std::vector<std::shared_ptr<Object>> queue_;
    void note(const std::shared_ptr<Object>& object);
};

} // namespace sunstone::optix6
