// SPDX-License-Identifier: Apache-2.0
// A recording: a device's results for every form, and the forms that its driver refused. The file
// is one zstd frame of text lines (device, hash of all inputs, then per form its status, the hash
// of its code, and its name) followed by the results, each output cut into planes of equal bytes,
// which compress better.
#pragma once

#include "forms/forms.h"
#include "forms/run_forms.h"

#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace conformance {

struct RecordedForm {
    Status status = Status::kPending;
    uint32_t code = 0; // hash
    std::vector<uint8_t> results;
};

struct Recording {
    std::string device;
    uint32_t inputs = 0; // hash
    std::map<std::string, RecordedForm> forms;
};

uint32_t hashOf(const void* data, size_t size);
uint32_t codeHash(const Form& form);
uint32_t inputsHash();

void save(const std::string& file, const std::vector<Form>& forms, const Results& results);
// Ends the process if the file is not a recording.
Recording load(const std::string& file);

// The head of recordings of other kinds of cases, in lines: the kind, the number of cases and
// further data of the kind; the device; then for each case its status as a letter ('r' has
// results), the hash of all its inputs, and its name.
struct CaseHead {
    struct Case {
        char status = '?';
        uint32_t hash = 0;
        std::string name;
    };
    std::string device, note;
    std::vector<Case> cases;
    size_t end = 0; // where the results begin
};
// Ends the process if the file is of another kind.
CaseHead readHead(const std::string& bytes, const std::string& file, const char* kind);

// One zstd frame around text and results, for recordings of other kinds too.
void saveCompressed(const std::string& file, const std::string& bytes);
std::string loadCompressed(const std::string& file);

} // namespace conformance
