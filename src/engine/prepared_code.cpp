// SPDX-License-Identifier: Apache-2.0
#include "engine/prepared_code.h"

namespace sunstone::engine {

bool PreparedCode::find(const std::string& key, std::string& value) {
    {
        std::lock_guard lock(mutex_);
        const auto found = values_.find(key);
        if (found != values_.end()) {
            value = found->second;
            return true;
        }
    }
    if (!next_ || !next_->find(key, value))
        return false;
    std::lock_guard lock(mutex_);
    values_[key] = value;
    return true;
}

void PreparedCode::insert(const std::string& key, const std::string& value) {
    {
        std::lock_guard lock(mutex_);
        values_[key] = value;
    }
    if (next_)
        next_->insert(key, value);
}

} // namespace sunstone::engine
