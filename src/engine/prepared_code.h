// SPDX-License-Identifier: Apache-2.0
// Machine code of a module's programs, whoever asked for it first: a task, a pipeline, or the
// question how much stack a program takes.
#pragma once

#include "compiler/compiler.h"

#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>

namespace sunstone::engine {

// Compiled pieces of one module, and behind them the disk cache if there is one.
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
