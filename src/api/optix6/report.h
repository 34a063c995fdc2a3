// SPDX-License-Identifier: Apache-2.0
// Texts of the usage report about work and its time. If the application wants no texts of a level,
// they cost one comparison.
#pragma once

#include "api/optix6/context.h"

#include <chrono>
#include <cmath>

namespace sunstone::optix6 {

// Levels of the manual.
constexpr int kReportErrors = 1, kReportStatistics = 2, kReportLaunches = 3;

class TimedReport {
public:
    explicit TimedReport(Context& context) : context_(context) {
        if (context.wantsReports(kReportStatistics))
            start_ = Clock::now();
    }
    // Reports a text that ends with the time since construction.
    template <class... Parts>
    void tell(int level, const char* tag, const Parts&... parts) const {
        if (!context_.wantsReports(level))
            return;
        const std::chrono::duration<double, std::milli> time = Clock::now() - start_;
        context_.report(level, tag,
                        message(parts..., " in ", std::round(time.count() * 100) / 100, " ms"));
    }

private:
    using Clock = std::chrono::steady_clock;
    Context& context_;
    Clock::time_point start_;
};

} // namespace sunstone::optix6
