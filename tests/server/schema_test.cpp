#include "server/api/schema.h"

#include <gtest/gtest.h>

namespace photond {
namespace {

/// The places at which `value` breaks `schema`.
std::vector<std::string> breaks(const char* schema, const char* value) {
  const Json document = Json::parse(schema);
  Schemas schemas(document);
  const Result<const Schema*> read = schemas.at("");
  if (!read) return {"schema: " + read.error().message + " at " + read.error().where};
  std::vector<std::string> places;
  for (const Violation& violation : check_value(**read, Json::parse(value))) places.push_back(violation.where);
  return places;
}

std::string detail(const char* schema, const char* value) {
  const Json document = Json::parse(schema);
  Schemas schemas(document);
  const auto found = check_value(**schemas.at(""), Json::parse(value));
  return found.empty() ? "" : found.front().detail;
}

using Places = std::vector<std::string>;
const Places kFine;
const Places kHere{""};

TEST(Schema, ChecksTypes) {
  const char* const values[] = {"null", "true", "1", "1.5", "\"a\"", "[]", "{}"};
  const char* const types[] = {"null", "boolean", "integer", "number", "string", "array", "object"};
  for (std::size_t t = 0; t < 7; ++t) {
    for (std::size_t v = 0; v < 7; ++v) {
      const bool admits = t == v || (t == 3 && v == 2);
      const std::string schema = std::string("{\"type\":\"") + types[t] + "\"}";
      EXPECT_EQ(breaks(schema.c_str(), values[v]), admits ? kFine : kHere) << types[t] << " " << values[v];
    }
  }
  EXPECT_EQ(breaks(R"({"type":"integer"})", "2.0"), kFine) << "an integer, says JSON Schema";
  EXPECT_EQ(breaks(R"({"type":["string","null"]})", "null"), kFine);
  EXPECT_EQ(breaks(R"({"type":["string","null"]})", "1"), kHere);
  EXPECT_EQ(breaks("{}", "[1,{}]"), kFine);
}

TEST(Schema, ChecksNumbersExactly) {
  const char* const schema = R"({"type":"integer","minimum":1,"maximum":18446744073709551615})";
  EXPECT_EQ(breaks(schema, "0"), kHere);
  EXPECT_EQ(breaks(schema, "-1"), kHere);
  EXPECT_EQ(breaks(schema, "1"), kFine);
  EXPECT_EQ(breaks(schema, "18446744073709551615"), kFine);
  EXPECT_EQ(breaks(schema, "18446744073709551616"), kHere);
  EXPECT_EQ(breaks(R"({"exclusiveMinimum":0})", "0"), kHere);
  EXPECT_EQ(breaks(R"({"exclusiveMinimum":0})", "-0.0"), kHere);
  EXPECT_EQ(breaks(R"({"exclusiveMinimum":0})", "1e-300"), kFine);
  EXPECT_EQ(breaks(R"({"maximum":-2})", "-1"), kHere);
  EXPECT_EQ(breaks(R"({"maximum":-2})", "\"-1\""), kFine) << "says nothing of strings";
}

TEST(Schema, ChecksStrings) {
  EXPECT_EQ(breaks(R"({"maxLength":2})", "\"äöü\""), kHere);
  EXPECT_EQ(breaks(R"({"maxLength":3})", "\"äöü\""), kFine) << "code points count";
  EXPECT_EQ(breaks(R"({"minLength":1})", "\"\""), kHere);
  EXPECT_EQ(breaks(R"({"maxLength":9,"pattern":"^a+$"})", "\"aaa\""), kFine);
  EXPECT_EQ(breaks(R"({"maxLength":9,"pattern":"^a+$"})", "\"aab\""), kHere);
  EXPECT_EQ(breaks(R"({"maxLength":9,"pattern":"^a+$"})", "\"aaa\\n\""), kHere);
  EXPECT_EQ(breaks(R"({"maxLength":9,"pattern":"b"})", "\"abc\""), kFine) << "patterns are not anchored";
  EXPECT_EQ(breaks(R"({"enum":["a","b"]})", "\"b\""), kFine);
  EXPECT_EQ(breaks(R"({"enum":["a","b"]})", "\"c\""), kHere);
  EXPECT_EQ(breaks(R"({"const":"a"})", "\"c\""), kHere);
  for (const char* text : {"\"2026-01-31T12:00:00Z\"", "\"2026-01-31T12:00:00.123+02:00\""})
    EXPECT_EQ(breaks(R"({"format":"date-time"})", text), kFine) << text;
  for (const char* text : {"\"\"", "\"2026-13-31T12:00:00Z\"", "\"2026-01-31 12:00:00\"", "\"2026-01-31T24:00:00Z\""})
    EXPECT_EQ(breaks(R"({"format":"date-time"})", text), kHere) << text;
}

TEST(Schema, ChecksMembersAndItems) {
  const char* const schema =
      R"({"type":"object","properties":{"a":{"type":"integer"},"x/y":{"type":"string"},
          "list":{"type":"array","items":{"type":"number"},"minItems":1,"maxItems":3}},
          "required":["a"],"additionalProperties":false})";
  EXPECT_EQ(breaks(schema, R"({"a":1,"x/y":"z","list":[1,2.5]})"), kFine);
  EXPECT_EQ(breaks(schema, "{}"), Places{"/a"});
  EXPECT_EQ(breaks(schema, R"({"a":"1","x/y":2,"list":[1,"2",true],"more":0,"~":0})"),
            (Places{"/a", "/x~1y", "/list/1", "/list/2", "/more", "/~0"}));
  EXPECT_EQ(breaks(schema, R"({"a":1,"list":[]})"), Places{"/list"});
  EXPECT_EQ(breaks(schema, R"({"a":1,"list":[1,2,3,4]})"), Places{"/list"});
  EXPECT_EQ(breaks(R"({"additionalProperties":{"type":"integer"}})", R"({"a":1,"b":"2"})"), Places{"/b"});
  EXPECT_EQ(breaks(R"({"minProperties":1})", "{}"), kHere);
}

TEST(Schema, OfSeveralFormsExactlyOneMustHold) {
  const char* const schema =
      R"({"oneOf":[{"type":"integer","minimum":0},{"type":"string"},{"type":"object","required":["eye"]}]})";
  EXPECT_EQ(breaks(schema, "3"), kFine);
  EXPECT_EQ(breaks(schema, "\"three\""), kFine);
  EXPECT_EQ(breaks(schema, "[3]"), kHere);
  EXPECT_EQ(breaks(schema, "-3"), kHere);
  EXPECT_EQ(breaks(schema, "{}"), Places{"/eye"}) << "the form that is meant says what is missing";
  EXPECT_EQ(breaks(R"({"oneOf":[{"type":"integer"},{"type":"number"}]})", "3"), kHere) << "both hold";
  EXPECT_EQ(breaks(R"({"oneOf":[{"type":"integer"},{"type":"number"}]})", "3.5"), kFine);
}

TEST(Schema, FollowsReferences) {
  const char* const schema =
      R"({"properties":{"a":{"$ref":"#/properties/b"},"b":{"type":"integer"},"c":{"$ref":"#/properties/a","maximum":3}}})";
  EXPECT_EQ(breaks(schema, R"({"a":1,"c":3})"), kFine);
  EXPECT_EQ(breaks(schema, R"({"a":"1","c":4})"), (Places{"/a", "/c"}));
}

TEST(Schema, SaysWhatIsWanted) {
  EXPECT_EQ(detail(R"({"properties":{"w":{"type":"integer","minimum":1,"maximum":16384}}})", R"({"w":0})"),
            "/w must be a whole number from 1 to 16384");
  EXPECT_EQ(detail(R"({"type":"number","exclusiveMinimum":0,"maximum":1000000})", "0"),
            "the message must be a number above 0 and up to 1000000");
  EXPECT_EQ(detail(R"({"type":"number","minimum":0.1,"maximum":175})", "0"),
            "the message must be a number from 0.1 to 175");
  EXPECT_EQ(detail(R"({"type":"integer","minimum":0,"maximum":18446744073709551615})", "-1"),
            "the message must be a whole number from 0 to 18446744073709551615");
  EXPECT_EQ(detail(R"({"enum":["png","jpg","exr"]})", "\"gif\""), "the message must be png, jpg or exr");
  EXPECT_EQ(detail(R"({"oneOf":[{"type":"integer","minimum":0},{"const":"latest"}]})", "true"),
            "the message must be a whole number from 0 on or latest");
  EXPECT_EQ(detail(R"({"type":"array","minItems":3,"maxItems":3})", "[]"), "the message must be an array of 3 items");
}

TEST(Schema, IsRefusedWhereItSaysMoreThanIsUnderstood) {
  for (const char* schema :
       {R"({"multipleOf":2})", R"({"type":"real"})", R"({"type":5})", R"({"properties":{"a":{"not":{}}}})",
        R"({"pattern":"("})", R"({"pattern":"a","maxLength":100000})", R"({"pattern":"a"})", R"({"format":"email"})",
        R"({"minimum":"1"})", R"({"maxLength":-1})", R"({"enum":[]})", R"({"oneOf":[]})", R"({"oneOf":[5]})",
        R"({"$ref":"#/nowhere"})", R"({"$ref":"other.json"})", R"({"required":[1]})", R"({"items":[{}]})", "5"}) {
    EXPECT_EQ(breaks(schema, "1").size(), 1u) << schema;
    EXPECT_EQ(breaks(schema, "1").front().substr(0, 7), "schema:") << schema;
  }
}

TEST(Schema, ListsNoMoreViolationsThanAnybodyReads) {
  std::string many = "{";
  for (int i = 0; i < 10'000; ++i) many += (i > 0 ? ",\"k" : "\"k") + std::to_string(i) + "\":0";
  EXPECT_EQ(breaks(R"({"additionalProperties":false})", (many + "}").c_str()).size(), 32u);
}

}  // namespace
}  // namespace photond
