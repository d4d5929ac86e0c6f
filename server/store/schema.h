#pragma once

#include <span>

#include "server/store/database.h"

namespace photond {

/// The tables of photond's database, as steps from an empty file to the present ones.
///
/// To add tables or columns, append one Migration at the end of the list in schema.cpp: its SQL runs once on every
/// data directory, in the transaction that also runs what else is new and sets the version. Never change or remove
/// a step that was on main: data directories out there have run it. Queries on the tables belong to the class that
/// owns them (Store, …), which takes a Database&; all of them share the one connection.
std::span<const Migration> schema();

}  // namespace photond
