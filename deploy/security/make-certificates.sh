#!/usr/bin/env bash
# Makes all that DDS Security needs, with OpenSSL: authorities, identities, and signed rules of who may read and write what.
#
#   make-certificates.sh DIR [--days N]                   all at once: DIR/authority, DIR/coordinator, and DIR/worker for all
#                                                         workers together. Another run renews the last two
# An identity for each host, whose private key never leaves it:
#   make-certificates.sh authority DIR                    once, on a machine that you trust; keep DIR/authority there
#   make-certificates.sh request FOLDER                   on the host: FOLDER/key.pem stays, FOLDER/request.pem goes to you
#   make-certificates.sh sign DIR REQUEST ROLE NAME OUT [--days N]   ROLE: coordinator or worker. Copy OUT/* into FOLDER.
#                                                         Again for the same NAME: renews
#   make-certificates.sh revoke DIR CERTIFICATE           DIR/authority/crl.pem then names it: copy that into the folders of
#                                                         all others; it counts for programs that start after that
# `--security` takes a folder with the six files (and crl.pem).
set -euo pipefail
umask 077

readonly authority_days=3650
readonly crl_days=3650 # a list that ran out would stop everybody

die() { echo "make-certificates.sh: $1" >&2; exit 2; }
usage() { sed -n '2,15s/^# \{0,1\}//p' "$0"; }

days=825
words=()
while [ $# -gt 0 ]; do
  case $1 in
    --days) days=${2:-}; shift $(($# > 1 ? 1 : 0)) ;;
    -h | --help) usage; exit 0 ;;
    -*) die "no option '$1': expected --days" ;;
    *) words+=("$1") ;;
  esac
  shift
done
case $days in '' | *[!0-9]*) die "--days '$days': expected a number" ;; esac
[ ${#words[@]} -gt 0 ] || { usage >&2; exit 2; }

new_key() { openssl genpkey -algorithm EC -pkeyopt ec_paramgen_curve:prime256v1 -out "$1" 2>/dev/null; }

# The two authorities and the rules for everybody, as far as they are not there.
make_authority() {
  mkdir -p "$authority"
  for name in identity_ca permissions_ca; do
    [ -e "$authority/$name.pem" ] && continue
    new_key "$authority/$name.key"
    openssl req -x509 -new -key "$authority/$name.key" -sha256 -days $authority_days -subj "/O=Coppice/CN=$name" \
      -out "$authority/$name.pem"
  done
  write_governance
  sign_rules governance "$authority"
}

# Everything that leaves a participant is encrypted (rtps_protection_kind); one layer is enough, each costs as much again.
write_governance() {
  cat > "$authority/governance.xml" <<XML
<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"
     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_governance.xsd">
  <domain_access_rules>
    <domain_rule>
      <domains><id_range><min>0</min><max>230</max></id_range></domains>
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>ENCRYPT</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>NONE</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
XML
}

# $1.xml beside the authorities, signed into the folder $2.
sign_rules() {
  openssl smime -sign -in "$authority/$1.xml" -text -out "$2/$1.smime" \
    -signer "$authority/permissions_ca.pem" -inkey "$authority/permissions_ca.key"
}

topics() { for topic in "$@"; do printf '<topic>%s</topic>' "$topic"; done; }
grant() { # certificate, topics to publish, topics to subscribe
  local subject
  subject=$(openssl x509 -in "$1" -noout -subject -nameopt RFC2253)
  cat <<XML
    <grant name="$(basename "$(dirname "$1")" | tr -cd 'A-Za-z0-9_-')">
      <subject_name>${subject#subject=}</subject_name>
      <validity><not_before>$(date -u -d '1 day ago' +%Y-%m-%dT%H:%M:%S)</not_before><not_after>$(date -u -d "+$days days" +%Y-%m-%dT%H:%M:%S)</not_after></validity>
      <allow_rule>
        <domains><id_range><min>0</min><max>230</max></id_range></domains>
        <publish><topics>$2</topics><partitions><partition>*</partition></partitions></publish>
        <subscribe><topics>$3</topics><partitions><partition>*</partition></partitions></subscribe>
      </allow_rule>
      <default>DENY</default>
    </grant>
XML
}

# idl/README.md: who writes which topic. The version in a name is left open: programs of two versions refuse each other.
from_coordinator=$(topics coppice_Control coppice_Fleet 'coppice_v*_Task' 'coppice_v*_ChainBlock')
from_worker=$(topics coppice_Hello 'coppice_v*_Answer' 'coppice_v*_ChainRequest')
grant_of() { # role, certificate
  case $1 in
    # `coppice workers`, with a coordinator's identity, also listens to coordinators.
    coordinator) grant "$2" "$from_coordinator" "$from_worker$(topics coppice_Control coppice_Fleet)" ;;
    worker) grant "$2" "$from_worker" "$(topics coppice_Control 'coppice_v*_Task' 'coppice_v*_ChainBlock')" ;;
    *) die "role '$1': expected coordinator or worker" ;;
  esac
}

# Grants from standard input, as signed permissions in the folder $1.
write_permissions() {
  {
    echo '<?xml version="1.0" encoding="UTF-8"?>'
    echo '<dds xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance"'
    echo '     xsi:noNamespaceSchemaLocation="http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd">'
    echo '  <permissions>'
    cat
    echo '  </permissions>'
    echo '</dds>'
  } > "$authority/permissions.xml"
  sign_rules permissions "$1"
}

# What everybody has: whom to believe, and what is protected.
share() {
  cp "$authority"/{identity_ca.pem,permissions_ca.pem,governance.smime} "$1/"
  if [ -e "$authority/crl.pem" ]; then
    cp "$authority/crl.pem" "$1/"
  fi
}

# A certificate for the key of a request; the name is the authority's choice, whatever the request says.
certify() { # request, common name, certificate
  openssl x509 -req -in "$1" -CA "$authority/identity_ca.pem" -CAkey "$authority/identity_ca.key" -CAcreateserial \
    -CAserial "$authority/identity_ca.srl" -subj "/O=Coppice/CN=$2" -sha256 -days "$days" -out "$3" 2>/dev/null ||
    die "$1: not a certificate request that is signed by its own key"
}

need_authority() {
  authority=$1/authority
  [ -e "$authority/identity_ca.key" ] || die "$authority holds no authority: make-certificates.sh authority $1"
}

case ${words[0]} in
  authority)
    [ ${#words[@]} -eq 2 ] || die "authority: expected DIR"
    authority=${words[1]}/authority
    make_authority
    echo "$authority can sign now; keep it to yourself."
    ;;

  request)
    [ ${#words[@]} -eq 2 ] || die "request: expected FOLDER"
    folder=${words[1]}
    mkdir -p "$folder"
    [ -e "$folder/key.pem" ] || new_key "$folder/key.pem"
    openssl req -new -key "$folder/key.pem" -sha256 -subj "/O=Coppice/CN=request" -out "$folder/request.pem"
    echo "$folder/request.pem is to be signed; $folder/key.pem stays here."
    ;;

  sign)
    [ ${#words[@]} -eq 6 ] || die "sign: expected DIR REQUEST ROLE NAME OUT"
    need_authority "${words[1]}"
    role=${words[3]} name=${words[4]} out=${words[5]}
    case $name in '' | *[!A-Za-z0-9._-]*) die "name '$name': expected letters, digits, '.', '_' or '-'" ;; esac
    case $role in coordinator | worker) ;; *) die "role '$role': expected coordinator or worker" ;; esac
    openssl req -in "${words[2]}" -noout -verify >/dev/null 2>&1 || die "${words[2]}: no certificate request"
    mkdir -p "$out"
    certify "${words[2]}" "$role-$name" "$out/certificate.pem"
    grant_of "$role" "$out/certificate.pem" | write_permissions "$out"
    share "$out"
    echo "$out: copy its files beside the key of $role $name, for $days days."
    ;;

  revoke)
    [ ${#words[@]} -eq 3 ] || die "revoke: expected DIR CERTIFICATE"
    need_authority "${words[1]}"
    openssl verify -CAfile "$authority/identity_ca.pem" -no_check_time "${words[2]}" >/dev/null 2>&1 ||
      die "${words[2]}: no certificate of this authority"
    [ -e "$authority/index.txt" ] || : > "$authority/index.txt"
    [ -e "$authority/crlnumber" ] || echo 01 > "$authority/crlnumber"
    printf '[ca]\ndefault_ca=ours\n[ours]\ndatabase=%s\ncrlnumber=%s\ndefault_md=sha256\nunique_subject=no\n' \
      "$authority/index.txt" "$authority/crlnumber" > "$authority/ca.conf"
    ca=(openssl ca -config "$authority/ca.conf" -cert "$authority/identity_ca.pem" -keyfile "$authority/identity_ca.key")
    # One that is revoked already stays so.
    serial=$(openssl x509 -in "${words[2]}" -noout -serial)
    if ! grep -q "^R.*[[:space:]]${serial#serial=}[[:space:]]" "$authority/index.txt"; then
      "${ca[@]}" -revoke "${words[2]}" 2>/dev/null || die "${words[2]}: cannot be revoked"
    fi
    "${ca[@]}" -gencrl -crldays $crl_days -out "$authority/crl.pem" 2>/dev/null
    echo "$authority/crl.pem: copy it into the folder of every coordinator and worker, and start them again."
    ;;

  *)
    [ ${#words[@]} -eq 1 ] || die "'${words[0]}': expected authority, request, sign, revoke, or DIR alone"
    folder=${words[0]}
    authority=$folder/authority
    make_authority
    for role in coordinator worker; do
      mkdir -p "$folder/$role"
      new_key "$folder/$role/key.pem"
      openssl req -new -key "$folder/$role/key.pem" -sha256 -subj "/O=Coppice/CN=$role" -out "$authority/request.pem"
      certify "$authority/request.pem" "$role" "$folder/$role/certificate.pem"
      rm "$authority/request.pem"
    done
    {
      grant_of coordinator "$folder/coordinator/certificate.pem"
      grant_of worker "$folder/worker/certificate.pem"
    } | write_permissions "$authority"
    for role in coordinator worker; do
      cp "$authority/permissions.smime" "$folder/$role/"
      share "$folder/$role"
    done
    echo "$folder/coordinator and $folder/worker are ready for --security, for $days days; keep $authority to yourself."
    ;;
esac
