#include "server/api/contract.h"

#include <gtest/gtest.h>

#include "server/api/check_request.h"
#include "server/api/openapi.h"

namespace photond {
namespace {

/// A contract with one GET operation with these further members.
std::string document(const std::string& members) {
  return R"({"openapi":"3.1.0","info":{},"security":[],"paths":{"/a/{id}":{"get":{"operationId":"a","responses":{"200":
    {"description":"fine"}})" +
         (members.empty() ? "" : "," + members) + "}}}}";
}

Error refusal(const std::string& text) {
  const Result<Contract> contract = Contract::read(text);
  return contract ? Error{} : contract.error();
}

TEST(Contract, IsRefusedWhereItSaysMoreThanIsUnderstood) {
  ASSERT_TRUE(Contract::read(document("")).ok());
  ASSERT_TRUE(Contract::read(kOpenApiText).ok()) << Contract::read(kOpenApiText).error().message;
  EXPECT_EQ(refusal("{").message, "the contract is not JSON");
  const std::pair<const char*, const char*> cases[] = {
      {R"("callbacks":{})", "/paths/~1a~1{id}/get"},
      {R"("security":[{"key":["root"]}])", "/paths/~1a~1{id}/get"},
      {R"("security":[{"key":["read"]},{}])", "/paths/~1a~1{id}/get"},
      {R"("parameters":[{"name":"x","in":"cookie","schema":{}}])", "/paths/~1a~1{id}/get/parameters/0"},
      {R"("parameters":[{"name":"x","in":"query","schema":{},"style":"form"}])", "/paths/~1a~1{id}/get/parameters/0"},
      {R"("parameters":[{"name":"x","in":"query","schema":{"not":{}}}])", "/paths/~1a~1{id}/get/parameters/0/schema"},
      {R"("parameters":[{"name":"x","in":"query"}])", "/paths/~1a~1{id}/get/parameters/0/schema"},
      {R"("parameters":[{"$ref":"#/nowhere"}])", "/paths/~1a~1{id}/get/parameters/0"},
      {R"("requestBody":{"content":{}})", "/paths/~1a~1{id}/get/requestBody"},
      {R"("requestBody":{"required":true,"content":{"a/b":{"schema":{"type":"x"}}}})",
       "/paths/~1a~1{id}/get/requestBody/content/a~1b/schema"}};
  for (const auto& [members, place] : cases) EXPECT_EQ(refusal(document(members)).where, place) << members;
}

class CheckRequest : public ::testing::Test {
 protected:
  CheckRequest()
      : contract_(std::move(*Contract::read(document(R"("parameters":[
          {"name":"id","in":"path","required":true,"schema":{"type":"string","maxLength":3}},
          {"name":"n","in":"query","schema":{"type":"integer","minimum":1,"maximum":9,"default":5}},
          {"name":"flag","in":"query","schema":{"type":"boolean"}},
          {"name":"job","in":"query","schema":{"type":"array","items":{"type":"string","maxLength":2}}},
          {"name":"must","in":"query","required":true,"schema":{"type":"string"}},
          {"name":"X-Id","in":"header","schema":{"type":"integer"}}],
          "requestBody":{"required":true,"content":{"application/json":{"schema":{"type":"object","required":["a"]}}}})")))) {
    request_.captures = {"abc"};
    request_.query = {{"must", "here"}};
  }

  std::optional<Json> check() {
    const auto wrong = check_parameters(contract_.operations().front(), request_);
    if (!wrong) return std::nullopt;
    return Json::parse(std::get<std::string>(wrong->body));
  }

  const Contract contract_;
  Request request_;
};

TEST_F(CheckRequest, GivesParametersTheirTypesAndDefaults) {
  ASSERT_FALSE(check());
  EXPECT_EQ(to_text(*request_.parameters), R"({"id":"abc","n":5,"job":[],"must":"here"})");
  request_.query = {{"must", "7"}, {"n", "9"}, {"flag", "true"}, {"job", "a"}, {"job", "b"}};
  request_.headers = {{"x-id", "12"}};
  ASSERT_FALSE(check());
  EXPECT_EQ(to_text(*request_.parameters),
            R"({"id":"abc","n":9,"flag":true,"job":["a","b"],"must":"7","X-Id":12})");
}

TEST_F(CheckRequest, ListsAllMistakes) {
  request_.query = {{"n", "10"}, {"flag", "yes"}, {"job", "a"}, {"job", "long"}, {"other", "1"}};
  request_.headers = {{"x-id", "one"}};
  const auto problem = check();
  ASSERT_TRUE(problem);
  EXPECT_EQ((*problem)["status"], 400);
  EXPECT_EQ((*problem)["code"], "invalid_parameter");
  EXPECT_EQ((*problem)["pointer"], "?n");
  EXPECT_EQ((*problem)["detail"], "?n must be a whole number from 1 to 9");
  std::vector<std::string> places;
  for (const Json& error : (*problem)["errors"]) places.push_back(error["pointer"]);
  EXPECT_EQ(places, (std::vector<std::string>{"?n", "?flag", "?job/1", "?must", "X-Id", "?other"}));
}

TEST_F(CheckRequest, AParameterIsGivenOnce) {
  request_.query = {{"must", "a"}, {"n", "1"}, {"n", "2"}};
  EXPECT_EQ((*check())["pointer"], "?n");
}

TEST_F(CheckRequest, WhatIsWrongInThePathIsNotFound) {
  request_.captures = {"abcd"};
  const auto problem = check();
  ASSERT_TRUE(problem);
  EXPECT_EQ((*problem)["status"], 404);
  EXPECT_EQ((*problem)["pointer"], "{id}");
}

TEST_F(CheckRequest, NumbersAreDecimalAndWhole) {
  for (const char* text : {"", "+1", "-1", "1.0", "1e0", " 1", "0x1", "18446744073709551617"}) {
    request_.query = {{"must", "a"}, {"n", text}};
    EXPECT_TRUE(check()) << text;
  }
}

TEST_F(CheckRequest, ChecksJsonBodies) {
  const auto check_text = [this](const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    request_.body.assign(bytes.begin(), bytes.end());
    request_.content_type = "application/json";
    const auto wrong = check_body(contract_.operations().front(), request_);
    return wrong ? wrong->status : 0;
  };
  EXPECT_EQ(check_text("{"), 400);
  EXPECT_EQ(check_text("{}"), 422);
  EXPECT_EQ(check_text("[]"), 422);
  EXPECT_EQ(check_text(R"({"a":1,"a":2})"), 400) << "a key twice";
  EXPECT_EQ(check_text(R"({"a":1})"), 0);
  EXPECT_EQ((*request_.json)["a"], 1);
}

}  // namespace
}  // namespace photond
