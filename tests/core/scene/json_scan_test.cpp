#include "core/scene/gltf/json_scan.h"

#include <gtest/gtest.h>

namespace photond::gltf {
namespace {

const Schema kAnything;

bool accepts(std::string_view text, const JsonLimits& limits = {}) {
  return scan_json(text, kAnything, limits).ok();
}

TEST(JsonScan, AcceptsStrictJson) {
  for (const char* text :
       {"{}", " [1, -0.5e+3, 0, true, false, null, \"\"] ", R"({"a":{"b":[[]]}})",
        R"("\u00e9\ud83d\ude00\n\"")", "\"\xC3\xA9\xE2\x82\xAC\xF0\x9F\x98\x80\"", "1e-400"}) {
    EXPECT_TRUE(accepts(text)) << text;
  }
}

TEST(JsonScan, RefusesWhatIsNotJson) {
  for (const char* text : {"",
                           "{",
                           "[1,]",
                           "{\"a\":1,}",
                           "01",
                           "1.",
                           ".5",
                           "+1",
                           "1e",
                           "NaN",
                           "tru",
                           "'a'",
                           "\"\t\"",
                           "\"\\x\"",
                           "[1] 2",
                           "{\"a\":1 \"b\":2}",
                           "\xEF\xBB\xBF{}",
                           "/**/1",
                           "\"\\ud800\"",
                           "1e999"}) {
    EXPECT_FALSE(accepts(text)) << text;
  }
}

TEST(JsonScan, RefusesBadUtf8) {
  for (const char* text : {"\"\xFF\"", "\"\xC0\xAF\"", "\"\xE0\x80\xAF\"", "\"\xED\xA0\x80\"",
                           "\"\xF4\x90\x80\x80\"", "\"\xC3\""}) {
    EXPECT_FALSE(accepts(text));
  }
}

TEST(JsonScan, RefusesRepeatedMembersHoweverTheyAreSpelt) {
  EXPECT_FALSE(accepts(R"({"a":1,"a":2})"));
  EXPECT_FALSE(accepts(R"({"a":1,"\u0061":2})"));
  EXPECT_TRUE(accepts(R"({"a":1,"b":{"a":2}})"));
}

TEST(JsonScan, LimitsObjectsAndMembersOfFreeNames) {
  EXPECT_TRUE(accepts("[{},{}]", {.max_objects = 2}));
  EXPECT_FALSE(accepts("[{},{},{}]", {.max_objects = 2}));
  const Schema number{.kind = Schema::Kind::number};
  const Schema free_names{.kind = Schema::Kind::object, .others = &number};
  EXPECT_TRUE(scan_json(R"({"a":1,"b":2})", free_names, {.max_objects = 3}).ok());
  EXPECT_EQ(scan_json(R"({"a":1,"b":2,"c":3})", free_names, {.max_objects = 3}).error().where, "c");
}

TEST(JsonScan, LimitsDepthAndLooseValues) {
  EXPECT_TRUE(accepts(std::string(100, '[') + std::string(100, ']'), {.max_depth = 100}));
  const auto deep = scan_json(std::string(100'000, '['), kAnything, {});
  ASSERT_FALSE(deep.ok());
  EXPECT_EQ(deep.error().code, ErrorCode::limit_exceeded);
  EXPECT_FALSE(accepts("[1,2,3]", {.max_loose_values = 3}));
}

TEST(JsonScan, NamesThePlaceOfAMismatch) {
  static constexpr Schema number{.kind = Schema::Kind::number, .max = 10};
  static constexpr Schema numbers{.kind = Schema::Kind::array, .items = &number};
  const Field fields[] = {{"list", &numbers, true}};
  const Schema object{.kind = Schema::Kind::object, .fields = fields};
  EXPECT_EQ(scan_json(R"({"list":[1,"x"]})", object, {}).error().where, "list[1]");
  EXPECT_EQ(scan_json(R"({"list":[1,2,11]})", object, {}).error().where, "list[2]");
  EXPECT_EQ(scan_json(R"({})", object, {}).error().message, "member \"list\" is missing");
  EXPECT_TRUE(scan_json(R"({"list":[1],"other":{"free":[]}})", object, {}).ok());
}

}  // namespace
}  // namespace photond::gltf
