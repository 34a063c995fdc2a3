// SPDX-License-Identifier: Apache-2.0
// Children of fork. A child has one thread: it lacks the streams' and workers' threads, on which
// all work of the parent's objects waits. As with a GPU's driver, API calls in a child fail if the
// parent had initialised the library before fork. A child that calls exec is a new process.
#pragma once

namespace sunstone {

// The error text of calls in such a child.
extern const char* const kForkedChildText;

// Starts the detection of children. Called when the library is initialised; cheap to call again.
void watchForks();

// Whether this process is such a child.
bool isForkedChild();
// The same for entry points; the first such call logs a line. An entry point calls it before it
// takes a lock, because another thread of the parent may have held the lock.
bool refusesForkedChild();

} // namespace sunstone
