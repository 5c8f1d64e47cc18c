# Completion of the command calor in bash; zsh takes it after `autoload -U compinit bashcompinit && compinit && bashcompinit`.

# Offers the lines of a list: names of files may have blanks.
_calor_offer() {
  local IFS=$'\n'
  COMPREPLY=($1)
}

_calor() {
  local verbs="run check cloud show units verify new examples doc help plot report certify fit study optimise"
  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb=${COMP_WORDS[1]} words=
  COMPREPLY=()
  if [ "$COMP_CWORD" = 1 ]; then
    words="$verbs --help --version"
  elif [ "$before" = --units ]; then
    words="K degC degF"
  elif [ "$before" = --from ]; then
    words=$(calor examples 2>/dev/null | sed -n 's|^\([a-zA-Z][^ ]*/[^ ]*\).*|\1|p')
  elif [ "$before" = -o ]; then
    _calor_offer "$(compgen -d -- "$word")"
    return
  else
    case $verb in
      run) words="-o -j --units --quiet --restart --time-limit" ;;
      check) words="-j --units --numbers" ;;
      cloud) words="-j -o --units" ;;
      certify) words="--budget --methods --refine --twin -j -o" ;;
      fit) words="-j -o" ;;
      study) words="--rows --sobol -j -o" ;;
      optimise) words="--picture -o" ;;
      plot) words="section surface lines probes pool balance energy stress film --field --time --plane --format --film --dark --units -o" ;;
      report) words="--units -o" ;;
      verify) words="--json" ;;
      new) words="--from plate rod disc weld coating shock crack" ;;
      doc) words="--schema $(calor doc 2>/dev/null | sed -n 's/^### `\[*\([a-z_]*\).*/\1/p' | sort -u)" ;;
      help) words=$verbs ;;
    esac
  fi
  _calor_offer "$(compgen -W "$words" -- "$word")"
  case $verb in
    run | check | cloud | show | verify | certify | fit | study | optimise)
      [ "$COMP_CWORD" = 1 ] || [ "$before" = --units ] || [ "${word#-}" != "$word" ] ||
        _calor_offer "$(compgen -f -X '!*.toml' -- "$word"; compgen -d -- "$word")"
      ;;
    plot | report)
      [ "$COMP_CWORD" != 2 ] || _calor_offer "$(compgen -d -- "$word")"
      ;;
  esac
}
complete -o filenames -F _calor calor
