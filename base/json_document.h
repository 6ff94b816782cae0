// A JSON document that can be destroyed without memory.
#pragma once

#include <istream>
#include <nlohmann/json.hpp>
#include <streambuf>
#include <string_view>

namespace occam {

/// Holds a JSON document. The destructor of nlohmann's class moves nested values into a list first, which takes memory, and
/// the process ends if there is none. This one empties the values from the inside out, as deep as they are nested.
class JsonDocument {
public:
    JsonDocument() = default;
    /// Parses a text. Throws nlohmann::json::exception if it is not JSON.
    explicit JsonDocument(std::string_view text) : JsonDocument()  // so that the destructor runs where this throws
    {
        // json::parse() would hold half of a document by itself where memory fails in it.
        Characters characters(text);
        std::istream(&characters) >> root;
        while (characters.sgetc() != Characters::traits_type::eof())
            if (const char c = static_cast<char>(characters.sbumpc()); c != ' ' && c != '\t' && c != '\n' && c != '\r')
                throw nlohmann::json::other_error::create(501, "text follows the document", nullptr);
    }
    ~JsonDocument() { empty(root); }
    JsonDocument(const JsonDocument&) = delete;
    JsonDocument& operator=(const JsonDocument&) = delete;

    nlohmann::json root;

private:
    struct Characters : std::streambuf {
        explicit Characters(std::string_view text)
        {
            char* const first = const_cast<char*>(text.data());  // nothing is written
            setg(first, first, first + text.size());
        }
    };
    static void empty(nlohmann::json& value) noexcept
    {
        if (!value.is_structured()) return;
        for (nlohmann::json& child : value) empty(child);
        value.clear();
    }
};

}  // namespace occam
