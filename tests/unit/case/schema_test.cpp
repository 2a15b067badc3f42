/// The manual and the JSON Schema come from the table that parses.

#include <cctype>

#include "case/node.hpp"
#include "case/problems.hpp"
#include "case/tables.hpp"
#include "case_files.hpp"

namespace berm {
namespace {

/// Accepts exactly one JSON value (RFC 8259), for texts whose numbers std::stod understands.
class JsonReader {
public:
  explicit JsonReader(const std::string& text) : text_(text) {}
  bool accepts() { return value() && (skip(), at_ == text_.size()); }

private:
  void skip() {
    while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
  }
  bool take(char c) {
    skip();
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }
  bool word(const std::string& w) {
    if (text_.compare(at_, w.size(), w) != 0) return false;
    at_ += w.size();
    return true;
  }
  bool string() {
    if (!take('"')) return false;
    while (at_ < text_.size() && text_[at_] != '"') {
      if (static_cast<unsigned char>(text_[at_]) < 0x20) return false;
      at_ += text_[at_] == '\\' ? 2 : 1;
    }
    return take('"');
  }
  bool number() {
    std::size_t used = 0;
    try {
      (void)std::stod(text_.substr(at_, 40), &used);
    } catch (const std::exception&) {
      return false;
    }
    at_ += used;
    return true;
  }
  bool members(char end, bool with_keys) {
    if (take(end)) return true;
    do {
      if (with_keys && !(string() && take(':'))) return false;
      if (!value()) return false;
    } while (take(','));
    return take(end);
  }
  bool value() {
    skip();
    if (take('{')) return members('}', true);
    if (take('[')) return members(']', false);
    if (at_ < text_.size() && text_[at_] == '"') return string();
    return word("true") || word("false") || word("null") || number();
  }

  const std::string& text_;
  std::size_t at_ = 0;
};

struct Manual {
  std::string markdown = schema_markdown(), json = schema_json();

  /// Expects all keys, and those of their tables, in both texts; returns how many there are.
  int expect_rows(const std::vector<KeyInfo>& keys, const std::string& prefix) const {
    int n = 0;
    for (const KeyInfo& info : keys) {
      const std::string row = "| `" + prefix + info.key + "` |";
      EXPECT_NE(markdown.find(row), std::string::npos) << row;
      EXPECT_NE(json.find("\"" + info.key + "\": {"), std::string::npos) << row;
      EXPECT_FALSE(info.doc.empty()) << row;
      n += 1 + expect_rows(info.children, prefix + info.key + ".");
    }
    return n;
  }
};

TEST(Schema, everyKeyIsDocumented) {
  const Manual manual;
  int n = 0;
  for (const KeyInfo& info : case_table().keys()) {
    if (info.children.empty()) {
      n += manual.expect_rows({info}, "");
    } else {
      EXPECT_NE(manual.markdown.find("\n## [" + info.key), std::string::npos) << info.key;
      EXPECT_NE(manual.json.find("\n    \"" + info.key + "\": {"), std::string::npos) << info.key;
      n += manual.expect_rows(info.children, "");
    }
  }
  EXPECT_GT(n, 100);
}

TEST(Schema, lawsAppearByThemselves) {
  const std::string markdown = schema_markdown(), json = schema_json();
  for_each_law([&]<class L>(L) {
    EXPECT_NE(markdown.find("`" + std::string(L::name) + "`: " + std::string(L::doc)), std::string::npos);
    for (const auto& p : L::parameters()) {
      EXPECT_NE(markdown.find("| `" + p.key + "` |"), std::string::npos) << p.key;
      EXPECT_NE(json.find("\"" + p.key + "\": {"), std::string::npos) << p.key;
    }
  });
}

TEST(Schema, jsonIsJson) {
  const std::string json = schema_json();
  EXPECT_TRUE(JsonReader(json).accepts());
  EXPECT_FALSE(JsonReader(json.substr(0, json.size() - 3)).accepts());
  EXPECT_NE(json.find("https://json-schema.org/draft/2020-12/schema"), std::string::npos);
}

TEST(Schema, referenceInTheDocumentationIsUpToDate) {
  std::string stored = read_text(BERM_SOURCE_DIR "/docs/case_reference.md");
  while (stored.ends_with('\n')) stored.pop_back();
  EXPECT_EQ(stored + "\n", schema_markdown()) << "renew it: berm schema > docs/case_reference.md";
}

TEST(Suggestion, nearestWordOrAllOfThem) {
  const std::vector<std::string> keys = {"friction_angle", "cohesion", "law"};
  EXPECT_EQ(suggestion("frictoin_angle", keys), " (did you mean \"friction_angle\"?)");
  EXPECT_EQ(suggestion("cohesoin", keys), " (did you mean \"cohesion\"?)");
  EXPECT_EQ(suggestion("lwa", keys), " (did you mean \"law\"?)");
  EXPECT_EQ(suggestion("density", keys), " (valid: friction_angle, cohesion, law)");
  EXPECT_EQ(suggestion("x", {}), " (nothing is defined there)");
}

TEST(Node, tomlAndJsonText) {
  Node root;
  root.set("text", Node(std::string("a \"b\" \\ \n \x01 é")));
  root.set("whole", Node(std::int64_t{-3}));
  root.set("real", Node(2.0));
  root.set("tiny", Node(1e-30));
  root.set("pair", pair_node(0.1, -4.0));
  Node inner, deep;
  deep.set("odd key", Node(true));
  inner.set("deep", deep);
  root.set("table", Node(Node::Object{{"name", {}, inner}}));
  EXPECT_EQ(write_toml(root),
            "text = \"a \\\"b\\\" \\\\ \\u000A \\u0001 é\"\nwhole = -3\nreal = 2.0\ntiny = 1e-30\npair = [0.1, -4.0]\n"
            "\n[table.name]\ndeep = { \"odd key\" = true }\n");
  EXPECT_TRUE(JsonReader(write_json(root)).accepts());
}

}  // namespace
}  // namespace berm
