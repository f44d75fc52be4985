#include "common/wire/credentials.hpp"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <ctime>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <memory>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <system_error>

namespace coppice::wire {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;
using Certificate = std::unique_ptr<X509, decltype(&X509_free)>;
using RevocationList = std::unique_ptr<X509_CRL, decltype(&X509_CRL_free)>;
using Key = std::unique_ptr<EVP_PKEY, decltype(&EVP_PKEY_free)>;

Result<File> open_file(const std::filesystem::path& path) {
  File file(std::fopen(path.c_str(), "rbe"), &std::fclose);
  if (file == nullptr) {
    return bad_input(fmt::format("--security: cannot read {}: {} (deploy/security/make-certificates.sh makes it)",
                                 path.string(), std::generic_category().message(errno)));
  }
  return file;
}

Result<Certificate> read_certificate(const std::filesystem::path& path) {
  auto file = open_file(path);
  if (!file) {
    return tl::unexpected(file.error());
  }
  Certificate certificate(PEM_read_X509(file->get(), nullptr, nullptr, nullptr), &X509_free);
  if (certificate == nullptr) {
    return bad_input(fmt::format("--security: {} holds no certificate: expected one in PEM", path.string()));
  }
  return certificate;
}

// A key that anybody on the host may read is nobody's. Its group may: that is how systemd hands it to a dynamic user.
Result<void> check_private(const std::filesystem::path& path) {
  std::error_code error;  // a file that cannot be looked at cannot be opened either, which says why
  const auto mode = std::filesystem::status(path, error).permissions();
  if (!error && (mode & std::filesystem::perms::others_read) != std::filesystem::perms::none) {
    return bad_input(fmt::format("--security: {} can be read by everybody on this machine (mode {:03o}): chmod 600 it",
                                 path.string(), static_cast<unsigned>(mode) & 0777U));
  }
  return {};
}

// Nothing where nobody was revoked.
Result<void> check_not_revoked(const std::filesystem::path& folder, X509* authority, X509* certificate) {
  const std::filesystem::path path = folder / kRevoked;
  std::error_code error;
  if (!std::filesystem::exists(path, error)) {
    return {};
  }
  auto file = open_file(path);
  if (!file) {
    return tl::unexpected(file.error());
  }
  const RevocationList list(PEM_read_X509_CRL(file->get(), nullptr, nullptr, nullptr), &X509_CRL_free);
  if (list == nullptr || X509_CRL_verify(list.get(), X509_get0_pubkey(authority)) != 1) {
    return bad_input(fmt::format("--security: {} is no list of revoked certificates that {} beside it signed",
                                 path.string(), kIdentityAuthority));
  }
  X509_REVOKED* entry = nullptr;
  if (X509_CRL_get0_by_cert(list.get(), &entry, certificate) == 1) {
    return bad_input(
        fmt::format("--security: {} was revoked: make another with "
                    "deploy/security/make-certificates.sh",
                    (folder / kCertificate).string()));
  }
  return {};
}

// Whole days from now; negative: over.
int days_left(const X509* certificate) {
  int days = 0;
  int seconds = 0;
  return ASN1_TIME_diff(&days, &seconds, nullptr, X509_get0_notAfter(certificate)) == 1 ? days : 0;
}

Result<Key> read_key(const std::filesystem::path& path) {
  auto file = open_file(path);
  if (!file) {
    return tl::unexpected(file.error());
  }
  // Without a terminal nobody could be asked for a pass phrase.
  const auto no_phrase = [](char*, int, int, void*) { return -1; };
  Key key(PEM_read_PrivateKey(file->get(), nullptr, no_phrase, nullptr), &EVP_PKEY_free);
  if (key == nullptr) {
    return bad_input(
        fmt::format("--security: {} holds no private key: expected one in PEM, without a pass phrase", path.string()));
  }
  return key;
}

}  // namespace

Result<void> check_credentials(const std::filesystem::path& folder) {
  for (const char* name : {kPermissionsAuthority, kGovernance, kPermissions}) {
    if (auto file = open_file(folder / name); !file) {
      return tl::unexpected(file.error());
    }
  }
  const auto authority = read_certificate(folder / kIdentityAuthority);
  if (!authority) {
    return tl::unexpected(authority.error());
  }
  const auto certificate = read_certificate(folder / kCertificate);
  if (!certificate) {
    return tl::unexpected(certificate.error());
  }
  if (const auto secret = check_private(folder / kPrivateKey); !secret) {
    return secret;
  }
  const auto key = read_key(folder / kPrivateKey);
  if (!key) {
    return tl::unexpected(key.error());
  }
  if (X509_check_private_key(certificate->get(), key->get()) != 1) {
    return bad_input(
        fmt::format("--security: {} is not the key of {} beside it", (folder / kPrivateKey).string(), kCertificate));
  }
  if (X509_verify(certificate->get(), X509_get0_pubkey(authority->get())) != 1) {
    return bad_input(fmt::format("--security: {} was not signed by {} beside it", (folder / kCertificate).string(),
                                 kIdentityAuthority));
  }
  if (X509_cmp_current_time(X509_get0_notBefore(certificate->get())) > 0) {
    return bad_input(fmt::format("--security: {} is not valid yet: is this machine's clock right?",
                                 (folder / kCertificate).string()));
  }
  if (X509_cmp_current_time(X509_get0_notAfter(certificate->get())) < 0) {
    return bad_input(
        fmt::format("--security: {} is not valid any more: make another with "
                    "deploy/security/make-certificates.sh",
                    (folder / kCertificate).string()));
  }
  return check_not_revoked(folder, authority->get(), certificate->get());
}

std::string expiry_warning(const std::filesystem::path& folder) {
  for (const char* name : {kCertificate, kIdentityAuthority, kPermissionsAuthority}) {
    const auto certificate = read_certificate(folder / name);
    if (certificate && days_left(certificate->get()) <= kWarnDays) {
      return fmt::format(
          "{} ends in {} days: renew it with deploy/security/make-certificates.sh, or no program will accept it",
          (folder / name).string(), days_left(certificate->get()));
    }
  }
  return {};
}

std::vector<std::pair<std::string, std::int64_t>> certificate_ends(const std::filesystem::path& folder) {
  std::vector<std::pair<std::string, std::int64_t>> ends;
  if (folder.empty()) {
    return ends;
  }
  for (const char* name : {kCertificate, kIdentityAuthority, kPermissionsAuthority}) {
    const auto certificate = read_certificate(folder / name);
    std::tm time{};
    if (certificate && ASN1_TIME_to_tm(X509_get0_notAfter(certificate->get()), &time) == 1) {
      ends.emplace_back(name, static_cast<std::int64_t>(timegm(&time)));
    }
  }
  return ends;
}

namespace {
constexpr std::chrono::hours kLookEvery{1};
constexpr std::chrono::hours kWarnEvery{24};
}  // namespace

CertificateWatch::CertificateWatch(std::filesystem::path folder)
    : folder_(std::move(folder)),
      next_look_(std::chrono::steady_clock::now()),
      next_warning_(next_look_ + kWarnEvery) {}  // the programs warn when they start

std::string CertificateWatch::look() {
  const auto now = std::chrono::steady_clock::now();
  if (folder_.empty() || now < next_look_) {
    return {};
  }
  next_look_ = now + kLookEvery;
  const std::int64_t today = std::time(nullptr);
  for (const auto& [file, end] : certificate_ends(folder_)) {
    const std::string path = (folder_ / file).string();
    if (end <= today && ended_ != path) {
      ended_ = path;
      const std::time_t time = end;
      return fmt::format(
          "{} ended at {:%Y-%m-%d %H:%M:%S} UTC: nobody lets this program in any more. Renew it "
          "(deploy/security/make-certificates.sh) and start again",
          path, fmt::gmtime(time));
    }
    if (end > today) {
      next_look_ = std::min(next_look_, now + std::chrono::seconds(end - today + 1));
    }
  }
  if (now >= next_warning_) {
    next_warning_ = now + kWarnEvery;
    return expiry_warning(folder_);
  }
  return {};
}

}  // namespace coppice::wire
