// SPDX-License-Identifier: Apache-2.0
// A copy of another rank's context; see scene_sender.h.
#pragma once

#include "api/optix6/context.h"

#include <map>
#include <string_view>

namespace sunstone::optix6 {

class Reader;

class Replica {
public:
    // `device`: an ordinal of this machine, modulo the number of its devices.
    explicit Replica(unsigned device);
    ~Replica();
    // Throws Error or Failure: the copy is then unusable.
    void apply(std::string_view changes);
    Context& context() { return *context_; }
    std::shared_ptr<Object> find(uint64_t number) const;

private:
    template <class Body>
    void forEachRecord(std::string_view changes, const Body& body);
    void create(Reader& in, uint64_t number, Kind kind);
    void readFields(Reader& in, Object& object);
    void readBuffer(Reader& in, Buffer& buffer);
    void readScope(Reader& in, Scoped& object);

    std::shared_ptr<Context> context_;
    std::map<std::string, std::string> texts_; // by digest
    std::map<uint64_t, std::shared_ptr<Object>> objects_;
};

} // namespace sunstone::optix6
