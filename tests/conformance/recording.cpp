// SPDX-License-Identifier: Apache-2.0
// See recording.h.
#include "recording.h"

#include "driver.h"
#include "inputs.h"
#include "module_writer.h"

#include <zstd.h>

#include <fstream>
#include <iterator>
#include <sstream>

namespace conformance {

namespace {

constexpr char kStatusLetters[] = {'?', 'r', '-', 'x'}; // by Status

// Byte k of every element, then byte k + 1 of every element.
void appendPlanes(std::string& to, const uint8_t* from, unsigned bytes) {
    for (unsigned k = 0; k < bytes; ++k)
        for (unsigned i = 0; i < kVectors; ++i)
            to.push_back(char(from[i * bytes + k]));
}
void readPlanes(uint8_t* to, const char* from, unsigned bytes) {
    for (unsigned k = 0; k < bytes; ++k)
        for (unsigned i = 0; i < kVectors; ++i)
            to[i * bytes + k] = uint8_t(*from++);
}

// The sizes of a form's outputs, one digit each.
std::string sizesOf(const Form& form) {
    std::string sizes;
    for (const Output& output : form.outputs)
        sizes += char('0' + bytesOf(output.type));
    return sizes;
}

} // namespace

uint32_t hashOf(const void* data, size_t size) {
    uint32_t hash = 2166136261u;
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ static_cast<const uint8_t*>(data)[i]) * 16777619u;
    return hash;
}

uint32_t codeHash(const Form& form) {
    std::string all = form.code;
    for (const std::string& input : form.inputs)
        all += " " + input;
    all += " " + sizesOf(form);
    return hashOf(all.data(), all.size());
}

uint32_t inputsHash() {
    const std::vector<uint64_t> inputs = allInputs();
    return hashOf(inputs.data(), inputs.size() * sizeof inputs[0]);
}

void saveCompressed(const std::string& file, const std::string& bytes) {
    std::string packed(ZSTD_compressBound(bytes.size()), 0);
    const size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 19);
    std::ofstream out(file, std::ios::binary);
    if (ZSTD_isError(size) || !out.write(packed.data(), std::streamsize(size)))
        quit(1, "cannot write " + file);
}

std::string loadCompressed(const std::string& file) {
    std::ifstream in(file, std::ios::binary);
    const std::string packed((std::istreambuf_iterator<char>(in)), {});
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (size == ZSTD_CONTENTSIZE_ERROR || size == ZSTD_CONTENTSIZE_UNKNOWN || size > 1ull << 30)
        quit(1, file + " is no recording");
    std::string bytes(size, 0);
    if (ZSTD_decompress(bytes.data(), bytes.size(), packed.data(), packed.size()) != size)
        quit(1, file + " is damaged");
    return bytes;
}

void save(const std::string& file, const std::vector<Form>& forms, const Results& results) {
    std::ostringstream head;
    head << "ptx " << kVectors << ' ' << forms.size() << ' ' << inputsHash() << '\n'
         << results.device << '\n';
    std::string data;
    for (size_t i = 0; i < forms.size(); ++i) {
        head << kStatusLetters[size_t(results.status[i])] << ' ' << codeHash(forms[i]) << ' '
             << sizesOf(forms[i]) << ' ' << forms[i].name << '\n';
        const uint8_t* at = results.results[i].data();
        if (results.status[i] == Status::kDone)
            for (const char size : sizesOf(forms[i])) {
                appendPlanes(data, at, unsigned(size - '0'));
                at += kVectors * size_t(size - '0');
            }
    }
    saveCompressed(file, head.str() + data);
}

Recording load(const std::string& file) {
    const std::string bytes = loadCompressed(file);
    std::istringstream in(bytes);
    std::string kind, line;
    size_t count = 0;
    unsigned vectors = 0;
    Recording recording;
    in >> kind >> vectors >> count >> recording.inputs;
    std::getline(in, line);
    std::getline(in, recording.device);
    if (kind != "ptx" || vectors != kVectors)
        quit(1, file + " is a recording of something else");
    std::vector<std::pair<RecordedForm*, std::string>> order;
    for (size_t i = 0; i < count && std::getline(in, line); ++i) {
        std::istringstream fields(line);
        char letter = 0;
        RecordedForm form;
        std::string sizes, name;
        fields >> letter >> form.code >> sizes >> std::ws;
        std::getline(fields, name);
        form.status = letter == 'r'   ? Status::kDone
                      : letter == '-' ? Status::kRefused
                                      : Status::kCrashed;
        RecordedForm& kept = recording.forms[name] = form;
        order.emplace_back(&kept, sizes);
    }
    auto at = size_t(in.tellg());
    for (auto& [form, sizes] : order) {
        if (form->status != Status::kDone)
            continue;
        for (const char digit : sizes) {
            const size_t size = size_t(digit - '0'), start = form->results.size();
            if (at + size * kVectors > bytes.size())
                quit(1, file + " ends too early");
            form->results.resize(start + size * kVectors);
            readPlanes(form->results.data() + start, bytes.data() + at, unsigned(size));
            at += size * kVectors;
        }
    }
    return recording;
}

CaseHead readHead(const std::string& bytes, const std::string& file, const char* kind) {
    std::istringstream in(bytes);
    CaseHead head;
    std::string line, found;
    size_t count = 0;
    in >> found >> count;
    if (found != kind)
        quit(1, file + " is a recording of something else");
    std::getline(in, head.note);
    std::getline(in, head.device);
    for (size_t i = 0; i < count && std::getline(in, line); ++i) {
        std::istringstream fields(line);
        CaseHead::Case one;
        fields >> one.status >> one.hash >> std::ws;
        std::getline(fields, one.name);
        head.cases.push_back(one);
    }
    head.end = size_t(in.tellg());
    return head;
}

} // namespace conformance
