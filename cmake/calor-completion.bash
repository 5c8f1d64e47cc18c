# Completion of the command calor in bash; zsh takes it after `autoload bashcompinit && bashcompinit`.
_calor() {
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]} words=
  COMPREPLY=()
  if [ "$COMP_CWORD" = 1 ]; then
    words="run check verify new examples doc help plot report --help --version"
  elif [ "$before" = --units ]; then
    words="K degC degF"
  elif [ "$before" = --from ]; then
    words=$(calor examples 2>/dev/null | sed -n 's|^\([a-zA-Z][^ ]*/[^ ]*\).*|\1|p')
  elif [ "$before" = -o ]; then
    mapfile -t COMPREPLY < <(compgen -d -- "$word")
    return
  else
    case $verb in
      run) words="-o -j --units --quiet --restart --time-limit" ;;
      check) words="-j --units" ;;
      verify) words="--json" ;;
      new) words="--from plate rod disc weld coating shock crack" ;;
      doc) words="--schema $(calor doc 2>/dev/null | sed -n 's/^### `\[*\([a-z_]*\).*/\1/p' | sort -u)" ;;
      help) words="run check verify new examples doc plot report" ;;
    esac
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  case $verb in
    run | check | verify)
      [ "$COMP_CWORD" = 1 ] || [ "$before" = --units ] || [ "${word#-}" != "$word" ] ||
        mapfile -t COMPREPLY < <(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word")
      ;;
    plot | report)
      [ "$COMP_CWORD" = 1 ] || mapfile -t COMPREPLY < <(compgen -d -- "$word")
      ;;
  esac
}
complete -o filenames -F _calor calor
