// The identity of a program under DDS Security: a folder of six files, made by deploy/security/make-certificates.sh,
// and a seventh once an identity was revoked.
// The plugins of DDS read it themselves; what they would pass over in silence (a key that is another certificate's
// never meets anybody, and says nothing) is looked for here first.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "common/error.hpp"

namespace coppice::wire {

inline constexpr const char* kIdentityAuthority = "identity_ca.pem";        // whose certificates are believed
inline constexpr const char* kPermissionsAuthority = "permissions_ca.pem";  // whose signature the next two carry
inline constexpr const char* kGovernance = "governance.smime";              // what is protected, and how
inline constexpr const char* kPermissions = "permissions.smime";            // who may read and write which topics
inline constexpr const char* kCertificate = "certificate.pem";
inline constexpr const char* kPrivateKey = "key.pem";

inline constexpr const char* kRevoked = "crl.pem";  // may be missing: whose certificates are believed no more

inline constexpr int kWarnDays = 30;  // before an end

// Errors name the file: one that cannot be read, a certificate that the authority did not sign or revoked, or whose
// time is over or has not come, a key that does not belong to it or that everybody may read, a list of the revoked that
// the authority did not sign.
Result<void> check_credentials(const std::filesystem::path& folder);

// A line to be logged where the certificate or the authority's own ends within kWarnDays; else empty.
// REQUIRES: check_credentials(folder).
std::string expiry_warning(const std::filesystem::path& folder);

// When the certificates in the folder end: name of the file, Unix time in seconds. As they are on disk now, so that a
// renewal shows; those that cannot be read are left out, and of an empty folder's name there are none.
std::vector<std::pair<std::string, std::int64_t>> certificate_ends(const std::filesystem::path& folder);

// Watches the end of an identity that is in use for months. Belongs to one thread.
class CertificateWatch {
 public:
  // Empty: there is nothing to watch.
  explicit CertificateWatch(std::filesystem::path folder);
  // A line to be logged, else empty: once a day in the last kWarnDays, and once when one has ended. To be called often.
  std::string look();

 private:
  std::filesystem::path folder_;
  std::chrono::steady_clock::time_point next_look_;
  std::chrono::steady_clock::time_point next_warning_;
  std::string ended_;  // that was told of
};

}  // namespace coppice::wire
