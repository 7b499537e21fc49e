# bash completion for servohil. Installed to share/bash-completion/completions/servohil; or: source this file.
# Names come from the program itself: whatever version is called completes its own.

_servohil_options() {  # of a subcommand, from its --help
  "${COMP_WORDS[0]}" "$@" --help 2>/dev/null | grep -oE '^ +(-[a-z], ?)?--[a-z0-9-]+' | grep -oE -- '--[a-z0-9-]+'
}

_servohil_faults() {
  "${COMP_WORDS[0]}" fault list --markdown 2>/dev/null | sed -n 's/^### //p'
}

_servohil_fault_parameters() {  # of the fault $1, as NAME=
  "${COMP_WORDS[0]}" fault show "$1" 2>/dev/null | sed -nE 's/^  ([a-z0-9_]+)  +[a-z].*;.*/\1=/p'
}

_servohil_values() {  # of what comes after an option
  case $1 in
    --when-fault) _servohil_faults ;;
    --when) printf '%s\n' x3_in v3_in_s p1_psi p3_psi p4_psi p8_psi ;;
  esac
}

_servohil() {
  local current=${COMP_WORDS[COMP_CWORD]} command=${COMP_WORDS[1]} words=""
  COMPREPLY=()
  if ((COMP_CWORD == 1)); then
    words="run simulate replay steady linear thesis check dbc fault status --help --version"
  elif [[ $command == fault && ${COMP_WORDS[COMP_CWORD-1]} == --when* ]]; then
    words=$(_servohil_values "${COMP_WORDS[COMP_CWORD-1]}")
  elif [[ $current == -* ]]; then
    if [[ $command == fault ]]; then words=$(_servohil_options fault "${COMP_WORDS[2]}")
    else words=$(_servohil_options "$command"); fi
  elif [[ $command == fault ]]; then
    if ((COMP_CWORD == 2)); then words="inject list show clear"
    elif ((COMP_CWORD == 3)) && [[ ${COMP_WORDS[2]} != list ]]; then words=$(_servohil_faults)
    elif [[ ${COMP_WORDS[2]} == inject || ${COMP_WORDS[2]} == clear ]]; then
      words=$(_servohil_fault_parameters "${COMP_WORDS[3]}")
      compopt -o nospace
    fi
  fi
  if [[ -n $words ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
  else
    compopt -o default
  fi
}
complete -F _servohil servohil
