// SPDX-License-Identifier: Apache-2.0
// Children of fork. A child has one thread: none of the streams' and workers' threads, on which all
// work of the parent's objects waits. As with a GPU's driver, the API calls of a child fail if its
// parent had initialised the library before it called fork. A child that calls exec is a new
// process.
#pragma once

namespace sunstone {

// Why calls of such a child fail.
extern const char* const kForkedChildText;

// From now on children are noticed. Called when the library is initialised; cheap to call again.
void watchForks();

// Whether this process is such a child.
bool isForkedChild();
// The same for entry points, with a line in the log at the first of them. An entry point asks
// before it takes a lock, because another thread of the parent may have held the lock.
bool refusesForkedChild();

} // namespace sunstone
