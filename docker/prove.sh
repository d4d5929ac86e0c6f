#!/usr/bin/env bash
# Runs the steps of the Dockerfile without Docker, each stage in a chroot made by debootstrap (needs root):
#   docker/prove.sh 12|13 FOLDER [STAGE]     FOLDER takes about 6 GB; STAGE: stop after it (client, build, test)
# Nothing of the host is seen inside but /proc, and what it trusts: certificates that NODE_EXTRA_CA_CERTS names. At its
# end the image's own command runs in a network of its own, and its own health check must find it healthy. Steps that
# are done are not done again; to repeat a stage, remove its folder.
set -euo pipefail

root=$(cd "$(dirname "$(readlink -f "${BASH_SOURCE[0]}")")/.." && pwd)
debian=${1:?usage: docker/prove.sh 12|13 FOLDER [STAGE]}
work=$(mkdir -p "${2:?a folder is needed}" && cd "$2" && pwd)
last_stage=${3:-}
case $debian in
  12) suite=bookworm ;;
  13) suite=trixie ;;
  *) echo "prove: Debian 12 or 13, not '$debian'" >&2; exit 2 ;;
esac

say() { printf 'prove: %s\n' "$*" >&2; }

# The Dockerfile's instructions, one a line, without comments.
instructions() {
  sed -e '/^[[:space:]]*#/d' "$root/docker/Dockerfile" | sed -e ':join' -e '/\\$/{N;s/\\\n[[:space:]]*//;b join}' | grep -v '^$'
}

leave() {
  local mounted
  for mounted in "$work"/*/proc; do
    ! mountpoint -q "$mounted" || umount "$mounted"
  done
}
trap leave EXIT

in_stage() { chroot "$work/$stage" /usr/bin/env -i PATH=/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin \
  HOME=/root "${arguments[@]}" sh -c "cd '$folder' || exit
$1"; }

from() {
  local base=$1
  stage=${3:-final}
  folder=/
  done_steps=$work/$stage.done
  [[ $base != debian:* ]] || base=base
  if [[ ! -d $work/$stage ]]; then
    say "stage $stage from $base"
    cp -ax "$work/$base" "$work/$stage.new"  # not the /proc that is mounted there
    mv "$work/$stage.new" "$work/$stage"
    : >"$done_steps"
    rm -f "$work/$stage.folder"
    [[ $base == base ]] || printf '%s' "$(cat "$work/$base.folder")" >"$work/$stage.folder"
  fi
  [[ ! -f $work/$stage.folder ]] || folder=$(cat "$work/$stage.folder")
  [[ ! -f $work/base/etc/host-certificates.pem ]] || cp "$work/base/etc/host-certificates.pem" "$work/$stage/etc/"
  mountpoint -q "$work/$stage/proc" || mount -t proc proc "$work/$stage/proc"
}

copy() {
  local source=$root
  if [[ $1 == --from=* ]]; then
    source=$work/${1#--from=}
    shift
  fi
  local -a names=("${@:1:$#-1}")
  local target=${!#} name
  [[ $target == /* ]] || target=$folder/$target
  target=$work/$stage$target
  if [[ ${#names[@]} -gt 1 || ${!#} == */ || ${!#} == ./ ]]; then mkdir -p "$target"; else mkdir -p "$(dirname "$target")"; fi
  for name in "${names[@]}"; do
    if [[ -d $source/$name ]]; then
      mkdir -p "$target"
      # What Dockerfile.dockerignore leaves out.
      tar -C "$source/$name" --exclude=./node_modules --exclude=./dist/cache -cf - . | tar -C "$target" -xf -
    else
      cp "$source/$name" "$target"
    fi
  done
}

# Runs the image's command as its user, in a network of its own, and its health check against it. Before that a key is
# made, as compose.yaml says: without one photond serves no address that others can reach.
run_image() {
  local user=$1 command=$2 check=$3
  say "running: $command"
  chroot --userspec="$user" "$work/$stage" photond key create --scope admin --data /data >/dev/null
  unshare --net --fork bash -c "
    ip link set lo up
    chroot --userspec='$user' '$work/$stage' $command &
    server=\$!
    trap 'kill \$server; wait \$server' EXIT
    for attempt in \$(seq 100); do
      chroot --userspec='$user' '$work/$stage' $check && exit 0
      sleep 0.1
    done
    exit 1"
}

[[ -d $work/base ]] || {
  say "debootstrap $suite"
  debootstrap --variant=minbase "$suite" "$work/base.new" http://deb.debian.org/debian >"$work/debootstrap.log"
  mv "$work/base.new" "$work/base"
}

arguments=(DEBIAN="$debian")
if [[ -n ${NODE_EXTRA_CA_CERTS:-} ]]; then
  cp "$NODE_EXTRA_CA_CERTS" "$work/base/etc/host-certificates.pem"
  arguments+=(NODE_EXTRA_CA_CERTS=/etc/host-certificates.pem)
fi
user=root entry='' command='' check=''
mapfile -t lines < <(instructions)
for line in "${lines[@]}"; do
  keyword=${line%% *}
  rest=${line#* }
  case $keyword in
    FROM)
      [[ -z $last_stage || ${stage:-} != "$last_stage" ]] || { say "stage $last_stage is done"; exit 0; }
      # shellcheck disable=SC2086
      from $rest
      continue
      ;;
    ARG)
      [[ " ${arguments[*]} " == *" ${rest%%=*}="* ]] || arguments+=("$rest")
      continue
      ;;
    WORKDIR) folder=$rest && mkdir -p "$work/$stage$folder" && printf '%s' "$folder" >"$work/$stage.folder" ; continue ;;
    USER) user=$rest ; continue ;;
    ENTRYPOINT) entry=$rest ; continue ;;
    CMD) command=$rest ; continue ;;
    HEALTHCHECK) check=${rest#*CMD } ; continue ;;
    VOLUME | EXPOSE) continue ;;
    RUN | COPY) ;;
    *) say "the Dockerfile has an instruction that is not known here: $keyword"; exit 1 ;;
  esac
  if grep -qxF "$line" "$done_steps"; then continue; fi
  say "$stage: $line"
  # shellcheck disable=SC2086
  if [[ $keyword == COPY ]]; then copy $rest; else in_stage "$rest"; fi
  printf '%s\n' "$line" >>"$done_steps"
done

# ["a", "b"] as words that a shell reads.
words() { python3 -c 'import json, shlex, sys; print(" ".join(shlex.quote(word) for word in json.loads(sys.argv[1])))' "$1"; }
run_image "$user" "$(words "$entry") $(words "$command")" "$(words "$check")"
say "healthy: the Dockerfile holds on Debian $debian"
