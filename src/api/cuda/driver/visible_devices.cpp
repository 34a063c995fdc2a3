// SPDX-License-Identifier: Apache-2.0
// See visible_devices.h.
#include "api/cuda/driver/visible_devices.h"

#include <cctype>
#include <cstdio>
#include <string>

namespace sunstone::api::cuda {

namespace {

std::string uuidText() {
    std::string text = "gpu-";
    for (int i = 0; i < 16; ++i) {
        char digits[4];
        std::snprintf(digits, sizeof digits, "%02x", unsigned(kDeviceUuid[i]));
        text += digits;
        if (i == 3 || i == 5 || i == 7 || i == 9)
            text += '-';
    }
    return text;
}

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && text.front() == ' ')
        text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ')
        text.remove_suffix(1);
    return text;
}

bool isDevice(std::string_view entry) {
    if (!entry.empty() && entry.find_first_not_of('0') == std::string_view::npos)
        return true;              // device 0
    constexpr size_t kPrefix = 4; // "GPU-"
    std::string lower;
    for (const char c : entry)
        lower += char(std::tolower(static_cast<unsigned char>(c)));
    return lower.size() > kPrefix && uuidText().starts_with(lower);
}

} // namespace

// The first entry decides: there is one device.
bool showsDevice(std::string_view list) {
    return isDevice(trimmed(list.substr(0, list.find(','))));
}

} // namespace sunstone::api::cuda
