// SPDX-License-Identifier: Apache-2.0
// Machine code of a module's programs, made at the first request: by a task, a pipeline, or a query
// of a program's stack size.
#pragma once

#include "compiler/compiler.h"

#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace sunstone::engine {

// Compiled pieces of one module, backed by the disk cache, if any.
class PreparedCode : public compiler::ObjectStore {
public:
    explicit PreparedCode(std::shared_ptr<compiler::ObjectStore> next) : next_(std::move(next)) {}
    bool find(const std::string& key, std::string& value) override;
    void insert(const std::string& key, const std::string& value) override;

private:
    std::shared_ptr<compiler::ObjectStore> next_; // may be null
    std::mutex mutex_;
    std::unordered_map<std::string, std::string> values_;
};

} // namespace sunstone::engine
