#pragma once

#include <memory>
#include <stdexcept>

#include "server/store/environments.h"
#include "server/store/job_files.h"
#include "server/store/schema.h"
#include "server/store/store.h"
#include "tests/support/temporary_folder.h"

namespace photond::test {

/// A store in a folder of its own.
struct TemporaryStore {
  TemporaryStore() { open(); }

  /// Opens it anew, as after a restart.
  void open() {
    files.reset();
    environments.reset();
    store.reset();
    database.reset();
    database = value(Database::open(folder.file("photond.db"), schema()));
    store = value(Store::open(*database, folder.path() / "scenes"));
    environments = value(Environments::open(*database, folder.path() / "environments"));
    files = value(JobFiles::open(*database, folder.path() / "frames", folder.path() / "checkpoints"));
  }

  TemporaryFolder folder;
  std::unique_ptr<Database> database;
  std::unique_ptr<Store> store;
  std::unique_ptr<Environments> environments;
  std::unique_ptr<JobFiles> files;

 private:
  template <class T>
  static T value(Result<T> result) {
    if (!result) throw std::runtime_error(result.error().message);
    return std::move(*result);
  }
};

}  // namespace photond::test
