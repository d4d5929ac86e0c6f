#pragma once

#include "server/api/authorize.h"
#include "server/api/message.h"

namespace photond {

/// What stands before every handler: who asks, and whether path, query and headers are as the contract says.
Admission admission(const Keyring& keys, const Operation& operation);

/// The handler, called with a body as the contract says. Where it `streams` or waits: only while the caller has a place
/// for a stream, and no longer than `keys` admit the caller. All references must outlive it.
Handler checked(const Keyring& keys, const Operation& operation, OpenStreams& open, bool streams, Handler handler);

}  // namespace photond
